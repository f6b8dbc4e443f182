//! A line chart: data series over two axes.

use crate::axis::limits;
use crate::error::PictureError;
use crate::line::Line;
use crate::plot::Plot;

/// Height of the figure without its legend (pixels).
const HEIGHT_PX: u32 = 360;

/// A line chart: data series over two axes.
#[derive(Debug, Clone)]
pub struct Chart {
    x: String,
    y: String,
    lines: Vec<Line>,
    bands: Vec<(f64, f64)>,
}

impl Chart {
    /// An empty chart with its axis titles, such as `t (s)`.
    pub fn new(x: impl Into<String>, y: impl Into<String>) -> Self {
        Self {
            x: x.into(),
            y: y.into(),
            lines: Vec::new(),
            bands: Vec::new(),
        }
    }

    /// Adds a line.
    #[must_use]
    pub fn line(mut self, line: Line) -> Self {
        self.lines.push(line);
        self
    }

    /// Adds lines.
    #[must_use]
    pub fn lines(mut self, lines: impl IntoIterator<Item = Line>) -> Self {
        self.lines.extend(lines);
        self
    }

    /// Shades a range of x behind the lines. The caption should say what the shading means.
    #[must_use]
    pub fn band(mut self, from: f64, to: f64) -> Self {
        self.bands.push((from, to));
        self
    }

    /// The chart as SVG text.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn svg(&self) -> Result<String, PictureError> {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = limits(points().map(|p| p.0));
        let y = limits(points().map(|p| p.1));
        let plot = Plot {
            titles: [&self.x, &self.y],
            limits: [x, y],
            height_px: HEIGHT_PX,
            lines: &self.lines,
            bands: &self.bands,
        };
        Ok(plot.svg()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_titles_names_and_bands() {
        let chart = Chart::new("t (s)", "x (m)")
            .line(Line::new("one", [(0.0, 0.0), (1.0, 2.0)]))
            .line(Line::new("two", [(0.0, 1.0), (1.0, 1.0)]).dashed())
            .line(Line::new("three", [(0.5, 1.0)]).dots())
            .band(0.2, 0.4);
        let svg = chart.svg().unwrap();
        for text in ["t (s)", "x (m)", "one", "two", "three"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("opacity=\"0.12\""));
    }

    #[test]
    fn an_empty_chart_shows_its_axes() {
        assert!(
            Chart::new("t (s)", "x (m)")
                .svg()
                .unwrap()
                .contains("t (s)")
        );
    }
}
