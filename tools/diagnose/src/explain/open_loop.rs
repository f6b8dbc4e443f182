//! Open loop over a horizon of 5 s: the state at the start is the filter's, then nothing is heard.

use crate::data::streams::WheelKind;
use crate::filter::wheel_channel::Tails;
use crate::model::command_to_wheels::{CommandToWheels, DriveRun};
use crate::model::drive::{AVERAGED, Response};

/// The horizon (s).
pub(crate) const HORIZON_S: f64 = 5.0;

/// Geometric mean over both wheels of the rms error (rad, or rad/s) of a drive with these parameters,
/// over the horizon; in runs of today alone.
pub(super) fn drive_error(drive: &CommandToWheels, at: &[f64]) -> f64 {
    let (mut squares, mut count) = ([0.0; 2], 0.0);
    let runs = drive.runs.iter().enumerate().skip(drive.before.runs);
    for (i, run) in runs {
        let (own, rows) = run_error(run, &drive.local(i, at));
        squares = [squares[0] + own[0], squares[1] + own[1]];
        count += rows;
    }
    let mean = squares.map(|s| (s / f64::max(count, 1.0) + 1e-16).sqrt());
    (mean[0] * mean[1]).sqrt()
}

/// Sums of square errors of both wheels, and how many rows they are of.
fn run_error(run: &DriveRun, at: &[f64]) -> ([f64; 2], f64) {
    let rows = &run.wheels.rows;
    let mut disturbance = [vec![0.0; 0], vec![0.0; 0]];
    let hear = &mut |channel: usize, _, d: f64| disturbance[channel].push(d);
    run.filter(at, Tails::Student, &mut |_| (), hear);
    let times_s = run.times_s(at);
    let response = Response::new(&run.commands, at);
    let mut hint = 0;
    let (mut squares, mut count) = ([0.0; 2], 0.0);
    let mut start = 0;
    let mut from = response.at(rows[0].time_s, &mut hint).angle_rad;
    for (k, row) in rows.iter().enumerate() {
        let now = response.averaged(row.time_s, at[AVERAGED], &mut hint);
        let h = row.time_s - rows[start].time_s;
        let [sum, difference] = [0, 1].map(|channel| {
            let (d, time_s): (f64, f64) = (disturbance[channel][start], times_s[channel]);
            match run.wheels.kind {
                WheelKind::Angle => d * time_s * (1.0 - (-h / time_s).exp()),
                WheelKind::Speed => d * (-h / time_s).exp(),
            }
        });
        let added = [sum + difference, sum - difference];
        if row.counts {
            count += 1.0;
            for i in 0..2 {
                let rest = match run.wheels.kind {
                    WheelKind::Angle => {
                        row.values[i] - rows[start].values[i] - (now.angle_rad[i] - from[i])
                    }
                    WheelKind::Speed => row.values[i] - now.speed_rad_s[i],
                };
                squares[i] += (rest - added[i]) * (rest - added[i]);
            }
        }
        if h >= HORIZON_S {
            (start, from) = (k, now.angle_rad);
        }
    }
    (squares, count)
}
