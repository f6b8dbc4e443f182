//! A line of a chart.

use plotters::style::RGBColor;

use crate::COLOURS;

/// A line of a chart. A point that is not finite leaves a gap.
#[derive(Debug, Clone)]
pub struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) mark: Mark,
    colour: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mark {
    Solid,
    Dashed,
    Dots,
}

impl Line {
    /// A solid line, named as in the legend, through points (x, y) in order.
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
            mark: Mark::Solid,
            colour: None,
        }
    }

    /// Dashed, so that black-and-white print tells it from the others.
    #[must_use]
    pub fn dashed(self) -> Self {
        let mark = Mark::Dashed;
        Self { mark, ..self }
    }

    /// Single dots, for measured samples.
    #[must_use]
    pub fn dots(self) -> Self {
        let mark = Mark::Dots;
        Self { mark, ..self }
    }

    /// The colour's number; lines that belong together share one. Without it every line of a chart
    /// has the colour of its own place.
    #[must_use]
    pub fn colour(self, number: usize) -> Self {
        let colour = Some(number);
        Self { colour, ..self }
    }

    pub(crate) fn shade(&self, place: usize) -> RGBColor {
        COLOURS[self.colour.unwrap_or(place) % COLOURS.len()]
    }

    /// Pieces without a gap, thinned to what a figure can show.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = Vec<(f64, f64)>> {
        let finite = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        let pieces = self.points.split(move |point| !finite(point));
        pieces.filter(|piece| !piece.is_empty()).map(thinned)
    }
}

/// Of every stretch its lowest and its highest point, in their order.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const STRETCHES: usize = 1500;
    if points.len() <= 2 * STRETCHES {
        return points.to_vec();
    }
    let stretches = points.chunks(points.len().div_ceil(STRETCHES));
    stretches
        .flat_map(|stretch| {
            let places = 0..stretch.len();
            let by_value = |a: &usize, b: &usize| stretch[*a].1.total_cmp(&stretch[*b].1);
            let low = places.clone().min_by(by_value).unwrap_or(0);
            let high = places.max_by(by_value).unwrap_or(0);
            [low.min(high), low.max(high)].map(|place| stretch[place])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_what_sticks_out() {
        let spike = |i: u32| if i == 77_777 { 9.0 } else { 0.0 };
        let points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), spike(i))).collect();
        let thin = thinned(&points);
        assert!(thin.len() <= 3000 && thin.contains(&(77_777.0, 9.0)));
        assert!(thin.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }

    #[test]
    fn what_is_not_finite_is_a_gap() {
        let line = Line::new("", [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (3.0, 2.0)]);
        let pieces: Vec<_> = line.pieces().collect();
        assert_eq!(pieces, [vec![(0.0, 1.0)], vec![(2.0, 1.0), (3.0, 2.0)]]);
    }
}
