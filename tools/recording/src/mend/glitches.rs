//! A row at another value, and back at the next row.

use super::column::{Column, Sample};
use super::jumps::IMPLAUSIBLE;
use super::scale::{MOST_FAULTS, Scale};

/// The rows on both sides of a glitch are no further apart than the wheel gets in that time.
const BACK: f64 = 2.0;

/// The cells that are glitches.
pub(super) fn glitches(column: Column<'_>, scale: &Scale) -> Vec<Sample> {
    let mut found: Vec<Sample> = Vec::new();
    let (mut before, mut here) = (None, None);
    column.visit(&mut |after| {
        if let (Some(a), Some(b)) = (before, here)
            && found.len() < MOST_FAULTS
            && is_glitch([a, b, after], scale)
        {
            found.push(b);
        } else {
            before = here;
        }
        here = Some(after);
    });
    found
}

fn is_glitch([a, b, c]: [Sample; 3], scale: &Scale) -> bool {
    let (away, back) = (b.value - a.value, c.value - b.value);
    let is_far = |step: f64, dt_s: f64| step.abs() > IMPLAUSIBLE * scale.reach(dt_s);
    away * back < 0.0
        && is_far(away, b.t_s - a.t_s)
        && is_far(back, c.t_s - b.t_s)
        && (c.value - a.value).abs() <= BACK * scale.reach(c.t_s - a.t_s)
}
