//! Counters that go on from another value: a driver that was started anew, a counter that was set to zero.

use super::column::{Column, Sample};
use super::scale::{MOST_FAULTS, Scale, fold};

/// A step of so many times what the wheel gets in that time is no motion. Recordings of real robots have up to
/// six, where rows were lost and the stamps do not show it.
pub(super) const IMPLAUSIBLE: f64 = 10.0;
/// The same for a step that ends at zero.
const IMPLAUSIBLE_TO_ZERO: f64 = 4.0;
/// A counter that was set to zero has gone no further than this many reaches when it is read.
const AT_ZERO: f64 = 2.0;
/// With more than one jump in so many rows, the column is no counter.
const ROWS_PER_JUMP: usize = 50;
/// So many jumps do not say that.
const FEW_JUMPS: usize = 10;

/// A step that is no motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jump {
    /// First row after it.
    pub(crate) row: usize,
    /// Time of the row before, and of that row (s).
    pub(crate) between_s: [f64; 2],
    /// Counts or rad.
    pub(crate) step: f64,
    /// What the wheel went in that time, by the speed before and after.
    pub(crate) expected: f64,
    /// Whether it ends at zero.
    pub(crate) to_zero: bool,
}

/// The jumps of a column; `None` if it has too many for a counter.
pub(super) fn jumps(
    column: Column<'_>,
    left_out: &[usize],
    modulus: Option<f64>,
    scale: &Scale,
) -> Option<Vec<Jump>> {
    let mut found: Vec<Jump> = Vec::new();
    let (mut last, mut per_s, mut rows) = (None::<Sample>, 0.0, 0);
    // the jump of the last row, whose speed afterwards is not known yet
    let mut open = false;
    column.visit_but(left_out, &mut |sample| {
        rows += 1;
        let Some(before) = last.replace(sample) else {
            return;
        };
        let dt_s = sample.t_s - before.t_s;
        let step = fold(sample.value - before.value, modulus);
        let to_zero = ends_at_zero(&before, &sample, scale);
        if is_implausible(step, dt_s, to_zero, scale) {
            open = found.len() < MOST_FAULTS;
            if open {
                found.push(Jump {
                    row: sample.row,
                    between_s: [before.t_s, sample.t_s],
                    step,
                    expected: per_s * dt_s,
                    to_zero,
                });
            }
        } else if dt_s > 0.0 {
            per_s = step / dt_s;
            if std::mem::take(&mut open)
                && let Some(jump) = found.last_mut()
            {
                let after = per_s * (jump.between_s[1] - jump.between_s[0]);
                jump.expected = (jump.expected + after) / 2.0;
            }
        }
    });
    (found.len() <= FEW_JUMPS.max(rows / ROWS_PER_JUMP)).then_some(found)
}

fn is_implausible(step: f64, dt_s: f64, to_zero: bool, scale: &Scale) -> bool {
    let limit = if to_zero {
        IMPLAUSIBLE_TO_ZERO
    } else {
        IMPLAUSIBLE
    };
    step.abs() > limit * scale.reach(dt_s)
}

fn ends_at_zero(before: &Sample, after: &Sample, scale: &Scale) -> bool {
    after.value.abs() <= AT_ZERO * scale.reach(after.t_s - before.t_s)
}
