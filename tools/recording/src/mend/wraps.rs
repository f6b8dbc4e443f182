//! Counters and angles that begin again at one end of their range when they leave it at the other.

use std::f64::consts::TAU;

use super::column::{Column, Sample};
use super::scale::{MOST_FAULTS, Scale, quantile};

/// A step of more than this share of all that the column ever shows is no motion of a wheel.
const SHARE_OF_RANGE: f64 = 0.5;
/// A step over a pause of more than so many intervals may be motion: it is where the wheel gets that far meanwhile.
const PAUSE: f64 = 3.0;
/// The size of a wrap is known to so many reaches of the wheel in one row.
const KNOWN_TO: f64 = 2.0;
/// Smallest modulus of counts: that of 7 bits. Counts of fewer than that are steps of a coarse encoder.
const FEWEST_COUNTS: f64 = 64.0;
/// Fewest rows that can show a range.
const FEWEST_ROWS: usize = 30;

/// The mean of sizes is within so many median deviations over the root of their number.
const DEVIATIONS: f64 = 4.0;
/// With so many steps through more than half of a usual range that is filled to this part, the column wraps, also
/// where the wheel is too fast to tell how often.
const MANY_TURNS: usize = 10;
const FILLED_TO: f64 = 0.03;

/// A step from one end of the range to the other.
#[derive(Debug, Clone, Copy)]
struct Turn {
    before: f64,
    after: f64,
    /// Size of the step, less what the wheel went before.
    size: f64,
    dt_s: f64,
}

/// The modulus of a column, if it wraps. `plain` is its scale as if it did not; `turn` is the number of counts of a turn, where known, or 2 π.
pub(super) fn modulus(
    column: Column<'_>,
    left_out: &[usize],
    plain: &Scale,
    counts: bool,
    turn: Option<f64>,
) -> Option<f64> {
    let [low, high] = range(column, left_out)?;
    let turns = turns(column, left_out, plain, high - low);
    let size = quantile(turns.iter().map(|turn| turn.size).collect(), 0.5)?;
    let scale = Scale::of(column, left_out, Some(size))?;
    let known_to = |turn: &Turn| KNOWN_TO * scale.reach(turn.dt_s) + f64::from(counts);
    let least = if counts { FEWEST_COUNTS } else { 0.9 * TAU };
    let agree = |turn: &Turn| (turn.size - size).abs() <= known_to(turn);
    if size < least || size < KNOWN_TO * scale.reach(0.0) || !turns.iter().all(agree) {
        return full_range(high - low, counts, turn).filter(|_| turns.len() >= MANY_TURNS);
    }
    let error = turns.iter().map(known_to).fold(f64::INFINITY, f64::min);
    let error = error.min(precision(&turns, size, counts).unwrap_or(error));
    let known = known_modulus(size, error, high - low, counts, turn);
    let is_sure =
        |modulus: &f64| turns.len() > 1 || turns.iter().all(|t| at_ends(t, *modulus, known_to(t)));
    match known {
        Some(modulus) => Some(modulus).filter(is_sure),
        None if turns.len() > 1 && counts => {
            roundest([high - low + 1.0, (size + error).max(high - low + 1.0)])
        }
        None => (turns.len() > 1).then_some(size),
    }
}

/// How well the size of several wraps is known; `None` for one.
fn precision(turns: &[Turn], size: f64, counts: bool) -> Option<f64> {
    let away = turns.iter().map(|turn| (turn.size - size).abs()).collect();
    let deviation = quantile(away, 0.5).filter(|_| turns.len() > 1)?;
    Some(DEVIATIONS * deviation / (turns.len() as f64).sqrt() + f64::from(counts))
}

/// Smallest and largest value.
fn range(column: Column<'_>, left_out: &[usize]) -> Option<[f64; 2]> {
    let (mut rows, mut low, mut high) = (0, f64::INFINITY, f64::NEG_INFINITY);
    column.visit_but(left_out, &mut |sample| {
        rows += 1;
        low = low.min(sample.value);
        high = high.max(sample.value);
    });
    (rows >= FEWEST_ROWS && high > low).then_some([low, high])
}

/// The steps through more than half of the range that are no motion.
fn turns(column: Column<'_>, left_out: &[usize], plain: &Scale, range: f64) -> Vec<Turn> {
    let mut turns = Vec::new();
    let (mut last, mut per_s) = (None::<Sample>, 0.0);
    column.visit_but(left_out, &mut |sample| {
        let Some(before) = last.replace(sample) else {
            return;
        };
        let (step, dt_s) = (sample.value - before.value, sample.t_s - before.t_s);
        let is_pause = dt_s > PAUSE * plain.interval_s;
        let is_motion = is_pause && step.abs() <= KNOWN_TO * plain.reach(dt_s);
        if is_motion || step.abs() <= SHARE_OF_RANGE * range {
            per_s = if dt_s > 0.0 { step / dt_s } else { per_s };
        } else if turns.len() < MOST_FAULTS {
            let size = (step - per_s * dt_s).abs();
            let (before, after) = (before.value, sample.value);
            turns.push(Turn {
                before,
                after,
                size,
                dt_s,
            });
        }
    });
    turns
}

/// Whether a single step leads from one end of the range of a counter to the other: 0 and the modulus, or
/// half of it on both sides of 0.
fn at_ends(turn: &Turn, modulus: f64, known_to: f64) -> bool {
    let (low, high) = (turn.before.min(turn.after), turn.before.max(turn.after));
    let half = modulus / 2.0;
    let near = |value: f64, end: f64| (value - end).abs() <= known_to;
    (near(low, 0.0) && near(high, modulus)) || (near(low, -half) && near(high, half))
}

/// The usual modulus whose range the values fill.
fn full_range(range: f64, counts: bool, turn: Option<f64>) -> Option<f64> {
    let size = range * (1.0 + FILLED_TO / 2.0);
    known_modulus(size, range * FILLED_TO / 2.0, range, counts, turn)
}

/// A modulus that is usual: a turn, or a power of two.
fn known_modulus(
    size: f64,
    error: f64,
    range: f64,
    counts: bool,
    turn: Option<f64>,
) -> Option<f64> {
    let powers = (7..=48).map(|bits| f64::from(bits).exp2());
    let powers = powers.filter(|_| counts);
    let least = if counts { range + 1.0 } else { range - 1e-6 };
    let fits = |modulus: &f64| (modulus - size).abs() <= error && *modulus >= least;
    turn.into_iter().chain(powers).find(fits)
}

/// The whole number in a range with the most zeros at its end: people choose round numbers.
fn roundest([low, high]: [f64; 2]) -> Option<f64> {
    let units = (0..=9).rev().map(|zeros| 10_f64.powi(zeros));
    let mut in_range = units.map(|unit| (low / unit).ceil() * unit);
    in_range.find(|number| *number > 0.0 && *number <= high)
}
