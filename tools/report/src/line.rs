//! One data series of a chart.

use plotters::style::RGBColor;

use crate::style::COLOURS;

/// One data series of a chart. A point that is not finite leaves a gap.
#[derive(Debug, Clone)]
pub struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) style: LineStyle,
    colour: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LineStyle {
    Solid,
    Dashed,
    Dots,
}

impl Line {
    /// A solid line through points (x, y) in order; `name` appears in the legend.
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
            style: LineStyle::Solid,
            colour: None,
        }
    }

    /// Dashed, so that it differs from solid lines in black-and-white print.
    #[must_use]
    pub fn dashed(self) -> Self {
        let style = LineStyle::Dashed;
        Self { style, ..self }
    }

    /// Separate dots instead of a line, for measured samples.
    #[must_use]
    pub fn dots(self) -> Self {
        let style = LineStyle::Dots;
        Self { style, ..self }
    }

    /// Sets the index of the colour, so that lines that belong together can share one. Without it
    /// the colour follows from the line's index in the chart.
    #[must_use]
    pub fn colour(self, number: usize) -> Self {
        let colour = Some(number);
        Self { colour, ..self }
    }

    pub(crate) fn rgb(&self, index: usize) -> RGBColor {
        COLOURS[self.colour.unwrap_or(index) % COLOURS.len()]
    }

    /// The stretches between gaps, decimated to what a figure can show.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = Vec<(f64, f64)>> {
        let finite = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        let pieces = self.points.split(move |point| !finite(point));
        pieces.filter(|piece| !piece.is_empty()).map(decimated)
    }
}

/// Min-max decimation: keeps the lowest and the highest point of each bucket, in order.
fn decimated(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const BUCKETS: usize = 1500;
    if points.len() <= 2 * BUCKETS {
        return points.to_vec();
    }
    let buckets = points.chunks(points.len().div_ceil(BUCKETS));
    buckets
        .flat_map(|bucket| {
            let indices = 0..bucket.len();
            let by_value = |a: &usize, b: &usize| bucket[*a].1.total_cmp(&bucket[*b].1);
            let low = indices.clone().min_by(by_value).unwrap_or(0);
            let high = indices.max_by(by_value).unwrap_or(0);
            [low.min(high), low.max(high)].map(|index| bucket[index])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimation_keeps_spikes() {
        let spike = |i: u32| if i == 77_777 { 9.0 } else { 0.0 };
        let points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), spike(i))).collect();
        let kept = decimated(&points);
        assert!(kept.len() <= 3000 && kept.contains(&(77_777.0, 9.0)));
        assert!(kept.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn a_point_that_is_not_finite_leaves_a_gap() {
        let line = Line::new("", [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (3.0, 2.0)]);
        let pieces: Vec<_> = line.pieces().collect();
        assert_eq!(pieces, [vec![(0.0, 1.0)], vec![(2.0, 1.0), (3.0, 2.0)]]);
    }
}
