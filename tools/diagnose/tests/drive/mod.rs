//! A drive of thirty seconds in which commands, wheels and poses are known in closed form.

use slipstream_recording::Recording;

use super::common::{noise, recording};

pub(crate) const RADIUS_M: f64 = 0.05;
pub(crate) const HALF_TRACK_M: f64 = 0.12;
const STEP_S: f64 = 2e-3;
const STEPS: u32 = 15_000;
/// Speeds (m/s) and turn rates (rad/s), two seconds each.
const TOLD: [[f64; 2]; 5] = [[0.3, 0.0], [0.3, 0.9], [0.1, -1.2], [0.4, 0.2], [-0.2, 0.6]];

/// Commanded speeds of both wheels (rad/s) in a step of the simulation. `stride` sets the order of the speeds.
fn told(step: u32, stride: usize) -> [f64; 2] {
    let [v, w] = TOLD[(step / 1000) as usize * stride % TOLD.len()];
    [v + HALF_TRACK_M * w, v - HALF_TRACK_M * w].map(|rim| rim / RADIUS_M)
}

/// Thirty seconds of a drive with a lag: wheels at 50 Hz in steps of `rounding_rad` (0: exact), poses at
/// 20 Hz with 2 mm and 4 mrad.
/// `stride` sets the order of the speeds.
pub(crate) fn recorded(stride: usize, lag_s: f64, rounding_rad: f64) -> Recording {
    let rounded = |angle: f64| {
        if rounding_rad > 0.0 {
            (angle / rounding_rad).floor() * rounding_rad
        } else {
            angle
        }
    };
    let mut columns: [Vec<f64>; 10] = Default::default();
    let mut add = |from: usize, row: &[f64]| {
        let places = row.iter().zip(&mut columns[from..]);
        places.for_each(|(value, column)| column.push(*value));
    };
    let (mut speeds, mut angles) = ([0.0_f64; 2], [0.0_f64; 2]);
    let [mut x, mut y, mut yaw] = [0.0, 0.0, 0.2_f64];
    let decay = if lag_s > 0.0 {
        (-STEP_S / lag_s).exp()
    } else {
        0.0
    };
    for k in 0..STEPS {
        let (t_s, u) = (f64::from(k) * STEP_S, told(k, stride));
        if k % 50 == 0 {
            add(0, &[t_s, u[0], u[1]]);
        }
        if k % 10 == 0 {
            add(3, &[t_s, rounded(angles[0]), rounded(angles[1])]);
        }
        if k % 25 == 7 {
            let [a, b, c] = [0.0, 0.3, 0.7].map(|part| noise(f64::from(k) + part));
            add(6, &[t_s, x + 2e-3 * a, y + 2e-3 * b, yaw + 4e-3 * c]);
        }
        // the exact solution over a step, in which the command holds
        let turned = [0, 1].map(|i| u[i] * STEP_S + (speeds[i] - u[i]) * lag_s * (1.0 - decay));
        speeds = [0, 1].map(|i| u[i] + (speeds[i] - u[i]) * decay);
        angles = [0, 1].map(|i| angles[i] + turned[i]);
        let way = RADIUS_M * f64::midpoint(turned[0], turned[1]);
        let turn = RADIUS_M * (turned[0] - turned[1]) / (2.0 * HALF_TRACK_M);
        x += way * (yaw + turn / 2.0).cos();
        y += way * (yaw + turn / 2.0).sin();
        yaw += turn;
    }
    recording("angles", columns)
}
