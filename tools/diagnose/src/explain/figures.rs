//! What the figures of all machines share, whatever predicts them.

use super::drawn_span::drawn_span;
use crate::answer::{ErrorLine, LawCurve, Paths, Point};
use crate::judge::{POSE, name};
use crate::predict::drawn::{Drawn, Place};
use crate::predict::predictor::unit;

/// Names of the pose's channels as seen from the robot.
const SEEN_FROM_ROBOT: [&str; 3] = ["forward", "sideways", "heading"];

/// Predictions of one run without and, where something was found, with what was found.
pub(super) struct OfRun<'a> {
    pub(super) run: usize,
    pub(super) before: &'a Drawn,
    pub(super) after: Option<&'a Drawn>,
    /// What is drawn is so much later than what was predicted (s).
    pub(super) origin_s: f64,
}

impl OfRun<'_> {
    /// Errors of each channel, whose sensors have these standard deviations. Wheels are measured by `angles` or by
    /// speeds; places are seen from the robot where its heading is known.
    pub(super) fn lines(
        &self,
        [angles, has_heading]: [bool; 2],
        deviation: impl Fn(usize) -> f64,
    ) -> Vec<ErrorLine> {
        let shown = |line: &[Point]| -> Vec<Point> {
            let all = line.iter();
            all.map(|(t_s, error)| (t_s + self.origin_s, *error))
                .collect()
        };
        let quantity = |channel: usize| match channel.checked_sub(POSE) {
            Some(part @ 0..=1) if has_heading => SEEN_FROM_ROBOT[part],
            Some(2) => SEEN_FROM_ROBOT[2],
            _ => name(channel),
        };
        let lines = self.before.errors.iter().enumerate();
        let lines = lines.filter(|(_, line)| line.iter().any(|(_, error)| error.is_finite()));
        lines
            .map(|(channel, before)| ErrorLine {
                run: self.run,
                quantity: quantity(channel),
                unit: unit(channel, angles),
                deviation: deviation(channel),
                before: shown(before),
                after: self
                    .after
                    .map_or_else(Vec::new, |after| shown(&after.errors[channel])),
            })
            .collect()
    }

    /// The part of a run with this span (s) that a picture of its path shows, by the errors of these channels.
    pub(super) fn span_s(&self, span_s: [f64; 2], channels: std::ops::Range<usize>) -> [f64; 2] {
        let sides = [(Some(self.before), 1.0), (self.after, -1.0)].into_iter();
        let squares = sides.flat_map(|(drawn, sign)| {
            let lines = drawn.map_or(&[][..], |own| &own.errors[channels.clone()]);
            let errors = lines.iter().flatten();
            errors.map(move |(t_s, error)| (*t_s, sign * error * error))
        });
        drawn_span(span_s, squares)
    }

    /// The path in this span (s); `None` where the robot is not seen. It is predicted as a whole where it is by the
    /// wheels, else in pieces.
    pub(super) fn path(&self, span_s: [f64; 2], by_wheels: bool) -> Option<Paths> {
        let within = |drawn: &Drawn, of: fn(&Place) -> Point| -> Vec<Point> {
            let all = drawn.path.iter();
            all.filter(|own| (span_s[0]..=span_s[1]).contains(&own.t_s))
                .map(of)
                .collect()
        };
        let seen = within(self.before, |own| own.seen);
        seen.iter().any(|(x, _)| x.is_finite()).then(|| Paths {
            run: self.run,
            span_s: span_s.map(|t_s| t_s + self.origin_s),
            in_pieces: !by_wheels,
            by_wheels,
            seen,
            before: within(self.before, |own| own.predicted),
            after: self
                .after
                .map_or_else(Vec::new, |after| within(after, |own| own.predicted)),
        })
    }
}

/// Root mean square by which predictions change: place (m) and heading (rad), of changes in channels.
pub(super) fn root_means(changes: impl Iterator<Item = (usize, f64)>) -> [Option<f64>; 2] {
    let mut sums = [[0.0_f64; 2]; 2];
    for (channel, change) in changes.filter(|(_, change)| change.is_finite()) {
        // two channels are one place
        let (quantity, count) = match channel.checked_sub(POSE) {
            Some(0..=1) => (0, 0.5),
            Some(2) => (1, 1.0),
            _ => continue,
        };
        let [squares, all] = sums[quantity];
        sums[quantity] = [squares + change * change, all + count];
    }
    sums.map(|[squares, count]| (count > 0.0).then(|| (squares / count).sqrt()))
}

/// A law of finding number `finding` as a curve, with what it acts on and its unit; `half` are half widths of 95 %
/// intervals of its values.
pub(super) fn curve(
    finding: usize,
    (quantity, unit): (&'static str, &'static str),
    driver: &'static str,
    knots: &[f64],
    [values, half]: [&[f64]; 2],
) -> LawCurve {
    let at = |sign: f64| -> Vec<Point> {
        let values = values.iter().zip(half);
        let values = values.map(|(value, half)| value + sign * half);
        knots.iter().copied().zip(values).collect()
    };
    LawCurve {
        finding,
        quantity,
        unit,
        driver,
        curve: at(0.0),
        band: [at(-1.0), at(1.0)],
    }
}
