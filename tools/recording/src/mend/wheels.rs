//! What is wrong with the counters or angles of both wheels.

use std::f64::consts::TAU;
use std::ops::Range;

use super::column::Column;
use super::glitches::glitches;
use super::jumps::{Jump, jumps};
use super::scale::{MOST_FAULTS, Scale, fold};
use super::wraps::modulus;
use crate::rows::Rows;

/// A step of half of the modulus may as well be one back; a little less, since nearly the fastest counts.
const KNOWN_STEP: f64 = 0.45;

/// What the columns of angles or counts hold instead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Level {
    /// The change since the row before.
    PerRow,
    /// A speed; one of it is so many rad/s.
    Speed(f64),
}

/// What is wrong with one wheel's column.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Fault {
    /// Rows at another value, with their times (s).
    pub(crate) glitches: Vec<(usize, f64)>,
    /// Where the column begins again (counts or rad).
    pub(crate) modulus: Option<f64>,
    /// Times at which it did (s).
    pub(crate) wraps_s: Vec<f64>,
    /// Steps that are no motion.
    pub(crate) jumps: Vec<Jump>,
    /// Whether there are too many of them for a counter.
    pub(crate) is_no_counter: bool,
    /// Whether the wheel is so fast that no step is known.
    pub(crate) is_too_fast: bool,
    /// Pauses in which the wheel may have wrapped more often than it shows: row after, and times (s).
    pub(crate) unclear: Vec<(usize, [f64; 2])>,
}

/// What is wrong with the wheels' columns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WheelFaults {
    /// The columns: right and left.
    pub(crate) names: [&'static str; 2],
    /// Whether they hold counts.
    pub(crate) counts: bool,
    /// Right and left.
    pub(crate) faults: [Fault; 2],
    /// What they hold instead of angles or counts.
    pub(crate) level: Option<Level>,
}

/// Looks both columns over. `None` if the stream holds speeds.
pub(crate) fn wheels(rows: &Rows<'_>, counts_per_rev: Option<f64>) -> Option<WheelFaults> {
    let ticks = ["ticks_right", "ticks_left"];
    let angles = ["angle_right_rad", "angle_left_rad"];
    let counts = rows.has(ticks[0]);
    let names = if counts { ticks } else { angles };
    let turn = if counts { counts_per_rev } else { Some(TAU) };
    names
        .iter()
        .all(|name| rows.has(name))
        .then(|| WheelFaults {
            names,
            counts,
            faults: names.map(|name| fault(Column { rows, name }, counts, turn)),
            level: None,
        })
}

impl WheelFaults {
    /// The longest run of rows in which it is known how far both wheels went, of so many rows.
    pub(crate) fn known_rows(&self, rows: usize) -> Range<usize> {
        let unclear = self.faults.iter().flat_map(|fault| &fault.unclear);
        let mut cuts: Vec<usize> = unclear.map(|(row, _)| *row).chain([0, rows]).collect();
        cuts.sort_unstable();
        let parts = cuts
            .iter()
            .zip(cuts.iter().skip(1))
            .map(|(from, to)| *from..*to);
        parts.max_by_key(ExactSizeIterator::len).unwrap_or(0..rows)
    }

    /// Whether nothing is wrong that can be undone.
    pub(crate) fn is_clean(&self) -> bool {
        if self.faults.iter().any(|fault| fault.is_too_fast) {
            return true;
        }
        let clean = |fault: &Fault| {
            fault.glitches.is_empty() && fault.modulus.is_none() && fault.jumps.is_empty()
        };
        self.level.is_none() && self.faults.iter().all(clean)
    }
}

fn fault(column: Column<'_>, counts: bool, turn: Option<f64>) -> Fault {
    let Some(scale) = Scale::of(column, &[], None) else {
        return Fault::default();
    };
    let mut wrong = glitches(column, &scale);
    let mut rows: Vec<usize> = wrong.iter().map(|sample| sample.row).collect();
    let modulus = modulus(column, &rows, &scale, counts, turn);
    if modulus.is_some() {
        // a wheel that rests where its counter wraps goes to and fro
        let outside = |value: f64| is_outside(column, &rows, value);
        wrong.retain(|sample| outside(sample.value));
        rows = wrong.iter().map(|sample| sample.row).collect();
    }
    let scale = Scale::of(column, &rows, modulus).unwrap_or(scale);
    let found = jumps(column, &rows, modulus, &scale);
    let mut fault = Fault {
        glitches: wrong
            .iter()
            .map(|sample| (sample.row, sample.t_s))
            .collect(),
        modulus,
        is_no_counter: found.is_none(),
        jumps: found.unwrap_or_default(),
        ..Fault::default()
    };
    if let Some(modulus) = modulus {
        look_at_wraps(column, &rows, modulus, &scale, &mut fault);
    }
    if counts {
        let whole = |jump: &mut Jump| jump.expected = jump.expected.round();
        fault.jumps.iter_mut().for_each(whole);
    }
    fault
}

/// Whether the value is beyond all others.
fn is_outside(column: Column<'_>, left_out: &[usize], value: f64) -> bool {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    column.visit_but(left_out, &mut |sample| {
        (low, high) = (low.min(sample.value), high.max(sample.value));
    });
    let margin = 0.01 * (high - low);
    value < low - margin || value > high + margin
}

/// Adds when the column wrapped, and where it is not known how often.
fn look_at_wraps(
    column: Column<'_>,
    left_out: &[usize],
    modulus: f64,
    scale: &Scale,
    fault: &mut Fault,
) {
    fault.is_too_fast = scale.fastest_per_s * scale.interval_s > KNOWN_STEP * modulus;
    let mut last = None;
    column.visit_but(left_out, &mut |sample| {
        let Some((t_s, value)) = last.replace((sample.t_s, sample.value)) else {
            return;
        };
        let step: f64 = sample.value - value;
        let (dt_s, folded) = (sample.t_s - t_s, fold(step, Some(modulus)));
        if (step - folded).abs() > 0.5 * modulus && fault.wraps_s.len() < MOST_FAULTS {
            fault.wraps_s.push(sample.t_s);
        }
        // a wheel that comes back to the same value has rested
        let may_be_more = scale.fastest_per_s * dt_s.max(scale.interval_s) > KNOWN_STEP * modulus;
        if may_be_more && folded != 0.0 && fault.unclear.len() < MOST_FAULTS {
            fault.unclear.push((sample.row, [t_s, sample.t_s]));
        }
    });
}
