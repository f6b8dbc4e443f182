//! Columns of angles or counts that hold something else: the change since the row before, or a speed.
//!
//! The rate of a running counter follows the speed that another source tells. Where the value itself follows it
//! and its rate does not, the value is no angle. The factor between the two tells the unit.

use std::f64::consts::TAU;

use super::motion::Windows;
use super::report::{Finding, Severity};
use super::similarity::{combine, cosine, similarity};
use crate::mend::{Level, WheelFaults};

/// Least cosine of values that follow a speed.
const FOLLOWS: f64 = 0.9;
/// The same without their means, where the unit does not confirm it: a counter with a large offset is alike to any
/// steady speed.
const FOLLOWS_CHANGES: f64 = 0.8;
/// Largest cosine of rates that do not follow it.
const DOES_NOT: f64 = 0.5;
/// Largest deviation of the factor from that of a unit, as a natural logarithm (30 %).
const MAX_LN_DEVIATION: f64 = 0.26;

/// What the columns hold, and who says so.
pub(crate) struct Seen {
    /// `None` where the unit is not known.
    pub(crate) level: Option<Level>,
    /// The source whose speed they follow.
    source: &'static str,
    cosines: [f64; 2],
}

/// Speed and turn rate by another source, and the factors from there to sum and difference of the wheels.
struct SpeedReference<'a> {
    name: &'static str,
    speeds: [&'a [f64]; 2],
    /// Sum and difference (rad/s) for one of it; `None` where the size of the robot is not known.
    wheels: Option<[f64; 2]>,
}

/// Looks whether the columns hold speeds. `interval_s` is the time between rows.
pub(crate) fn seen(windows: &Windows, faults: &WheelFaults, interval_s: f64) -> Option<Seen> {
    let command = [&windows.command_right, &windows.command_left];
    let told = [
        combine(command[0], command[1], |r, l| r + l),
        combine(command[0], command[1], |r, l| r - l),
    ];
    let size = windows.size_m.map(|[r, b]| [2.0 / r, 2.0 * b / r]);
    let of_body = |name, v, w| SpeedReference {
        name,
        speeds: [v, w],
        wheels: size,
    };
    let references = [
        of_body("pose", &windows.pose_v, &windows.pose_w),
        of_body("command", &windows.command_v, &windows.command_w),
        SpeedReference {
            name: "command",
            speeds: [&told[0], &told[1]],
            wheels: Some([1.0; 2]),
        },
        of_body("odometry and gyro", &windows.odometry_v, &windows.gyro_w),
    ];
    let mut found = references
        .iter()
        .filter_map(|reference| by(windows, reference, faults.counts, interval_s));
    let first = found.next()?;
    // one that knows the size of the robot tells the unit
    Some(if first.level.is_some() {
        first
    } else {
        found.find(|seen| seen.level.is_some()).unwrap_or(first)
    })
}

fn by(
    windows: &Windows,
    reference: &SpeedReference<'_>,
    counts: bool,
    interval_s: f64,
) -> Option<Seen> {
    let [right, left] = &windows.levels;
    let sums = |right: &[f64], left: &[f64]| {
        let sum = combine(right, left, |r, l| r + l);
        [sum, combine(right, left, |r, l| r - l)]
    };
    let (levels, rates) = (
        sums(right, left),
        sums(&windows.wheel_right, &windows.wheel_left),
    );
    let of_rates = reference.speeds.iter().zip(&rates);
    let of_rates = of_rates.filter_map(|(speed, rate)| cosine(rate, speed));
    let rate = of_rates.map(f64::abs).reduce(f64::max)?;
    let similar = |i: usize| Some((i, similarity(&levels[i], reference.speeds[i])?));
    let best = (0..2).filter_map(similar);
    let (i, level) = best.max_by(|(_, a), (_, b)| a.cosine.total_cmp(&b.cosine))?;
    if level.cosine < FOLLOWS || rate > DOES_NOT {
        return None;
    }
    let factor = reference.wheels.map(|wheels| level.factor / wheels[i]);
    let known = factor.and_then(|factor| unit(factor, windows, counts, interval_s));
    let changes = cosine(&centred(&levels[i]), &centred(reference.speeds[i]));
    if known.is_none() && changes.is_none_or(|cosine| cosine < FOLLOWS_CHANGES) {
        return None;
    }
    Some(Seen {
        level: known,
        source: reference.name,
        cosines: [level.cosine, rate],
    })
}

fn centred(values: &[f64]) -> Vec<f64> {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
}

/// What a column holds that shows `factor` for every rad/s.
fn unit(factor: f64, windows: &Windows, counts: bool, interval_s: f64) -> Option<Level> {
    let rad = if counts { windows.rad_per_count? } else { 1.0 };
    let is_near = |per_rad_s: f64| (factor / per_rad_s).ln().abs() < MAX_LN_DEVIATION;
    let units = [
        (interval_s / rad, Level::PerRow),
        (1.0 / rad, Level::Speed(rad)),
        (1.0, Level::Speed(1.0)),
        (360.0 / TAU, Level::Speed(TAU / 360.0)),
        (60.0 / TAU, Level::Speed(TAU / 60.0)),
        (1.0 / TAU, Level::Speed(TAU)),
    ];
    let mut known = units
        .into_iter()
        .filter(|(per_rad_s, _)| is_near(*per_rad_s));
    let (_, first) = known.next()?;
    // two units of one size cannot be told apart
    known.all(|(_, other)| other == first).then_some(first)
}

impl Seen {
    /// The finding: an error unless it can be undone.
    pub(crate) fn finding(&self, robot: &str, faults: &WheelFaults) -> Finding {
        let [right, left] = faults.names;
        let what = if faults.counts { "counts" } else { "angles" };
        let [level, rate] = self.cosines;
        let (id, holds) = match self.level {
            Some(Level::PerRow) => ("counts_per_row", format!("{what} per row")),
            Some(Level::Speed(rad_s)) => (
                "speeds_as_angles",
                format!("speeds (one is {rad_s:.4} rad/s)"),
            ),
            None if faults.counts => ("counts_per_row", "counts per row, or speeds".to_owned()),
            None => ("speeds_as_angles", "speeds, or angles per row".to_owned()),
        };
        let done = match self.level {
            Some(_) => "; the diagnosis reads them so",
            None => "; which of them is not known, and the wheels cannot be used",
        };
        let statement = format!(
            "{right} and {left} look like {holds}, not a running counter: they follow the speed by the {} (cosine \
             {level:.2}), and their changes do not ({rate:.2}){done}",
            self.source
        );
        let (severity, remedy) = match (self.level, faults.counts) {
            (Some(Level::PerRow), true) => (Severity::Warning, "sum them up before logging"),
            (Some(Level::PerRow), false) => (Severity::Warning, "log the angles themselves"),
            (Some(Level::Speed(_)), _) => (
                Severity::Warning,
                "name the columns speed_right_rad_s and speed_left_rad_s, in rad/s",
            ),
            (None, _) => (
                Severity::Error,
                "log running counters or angles, or give the model with --robot and encoder_counts_per_rev",
            ),
        };
        Finding::new(severity, robot, id, statement, remedy)
    }
}
