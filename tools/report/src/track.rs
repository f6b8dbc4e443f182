//! Paths on the floor, seen from above.

use std::ops::Range;

use crate::axis::limits;
use crate::error::PictureError;
use crate::line::Line;
use crate::plot::{Plot, plotting_area_px};

/// Paths on the floor, seen from above: x to the right, y up, both axes to the same scale.
#[derive(Debug, Clone, Default)]
pub struct Track {
    lines: Vec<Line>,
}

impl Track {
    /// An empty floor.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a path: points (x, y), both in m.
    #[must_use]
    pub fn line(mut self, line: Line) -> Self {
        self.lines.push(line);
        self
    }

    /// Adds paths.
    #[must_use]
    pub fn lines(mut self, lines: impl IntoIterator<Item = Line>) -> Self {
        self.lines.extend(lines);
        self
    }

    /// The figure as SVG text.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn svg(&self) -> Result<String, PictureError> {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = limits(points().map(|p| p.0));
        let y = limits(points().map(|p| p.1));
        // As high as the path needs at full width, within what fits on a page.
        let [wide, _] = plotting_area_px(100).map(f64::from);
        let wanted = wide * length(&y) / length(&x);
        let height_px = wanted.clamp(200.0, 640.0) as u32 + 68;
        let plot = Plot {
            titles: ["x (m)", "y (m)"],
            limits: to_scale([x, y], plotting_area_px(height_px)),
            height_px,
            lines: &self.lines,
            bands: &[],
        };
        Ok(plot.svg()?)
    }
}

fn length(range: &Range<f64>) -> f64 {
    range.end - range.start
}

/// Widens one of the ranges (m) so that a pixel has the same length on both axes.
fn to_scale(ranges: [Range<f64>; 2], plot_px: [u32; 2]) -> [Range<f64>; 2] {
    let [wide, high] = plot_px.map(f64::from);
    let m_per_px = (length(&ranges[0]) / wide).max(length(&ranges[1]) / high);
    let widened = |range: &Range<f64>, px: f64| {
        let more = (px * m_per_px - length(range)) / 2.0;
        range.start - more..range.end + more
    };
    [widened(&ranges[0], wide), widened(&ranges[1], high)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_axes_have_the_same_scale() {
        for ranges in [[0.0..10.0, 0.0..1.0], [0.0..1.0, -3.0..10.0]] {
            let [x, y] = to_scale(ranges.clone(), [800, 300]);
            assert!((length(&x) / 800.0 - length(&y) / 300.0).abs() < 1e-12);
            assert!(x.start <= ranges[0].start && ranges[0].end <= x.end);
            assert!(y.start <= ranges[1].start && ranges[1].end <= y.end);
        }
    }

    #[test]
    fn a_path_is_drawn() {
        let circle = (0..=60).map(|i| (f64::from(i) * 0.1).sin_cos());
        let svg = Track::new().line(Line::new("r1", circle)).svg().unwrap();
        assert!(svg.contains("r1") && svg.contains("y (m)"));
    }
}
