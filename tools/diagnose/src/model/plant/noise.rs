//! Noise of the filter over the plant as fitted parameters: logs of sizes and of correlation times.
//!
//! A size is never below its floor, the difference between two integrators of one model: of a disturbance
//! that is not there the likelihood says nothing, and its prior holds the logarithm.

use super::machine::Machine;
use crate::estimate::Prior;
use crate::filter::dynamic::Noise;

/// Where sizes are expected for a robot of 1.6 kg: surge force (N), yaw moment (N m), creep along (m/s), about
/// (rad/s) and across (m/s), torque of a wheel (N m).
const EXPECTED: [f64; SIZES] = [0.05, 0.002, 1e-3, 3e-3, 1e-3, 3e-3];
const EXPECTED_TIME_S: f64 = 0.3;
/// Standard deviations of the logs of sizes and times: a size is known to a factor of 20, a time to lie between
/// some hundredths of a second and some seconds.
const DEVIATION: f64 = 3.0;
const TIME_DEVIATION: f64 = 1.2;
/// Logs beyond which a size is held.
const HELD: f64 = 9.0;
/// Shortest and longest correlation time (s).
const TIMES_S: [f64; 2] = [0.01, 10.0];
/// Torque of a wheel, in the place of creep along and about where wheels can slide.
const TORQUE: usize = 5;
/// Sizes and times.
pub(super) const SIZES: usize = 6;
const TIMES: usize = 3;
pub(super) const COUNT: usize = SIZES + TIMES;

/// The prior of each.
pub(super) fn priors() -> impl Iterator<Item = Prior> {
    let of = |index| Prior {
        mean: 0.0,
        deviation: if index < SIZES {
            DEVIATION
        } else {
            TIME_DEVIATION
        },
    };
    (0..COUNT).map(of)
}

/// Those that runs with or without poses tell of.
pub(super) fn told(has_pose: bool) -> impl Iterator<Item = usize> {
    let of_pose = |index: &usize| (2..TORQUE).contains(index);
    (0..COUNT).filter(move |index| has_pose || !of_pose(index))
}

impl Machine {
    /// Noise at these parameters.
    pub(crate) fn noise(&self, at: &[f64], of_wheels: bool) -> Noise {
        let floor = self.floor(of_wheels);
        let mass = self.mass_share();
        let places = if of_wheels {
            [0, 1, TORQUE, TORQUE, 4]
        } else {
            [0, 1, 2, 3, 4]
        };
        let size = |k: usize| {
            let place = places[k];
            let of_force = place < 2 || place == TORQUE;
            let scale = if of_force { mass } else { 1.0 };
            let own = scale * EXPECTED[place] * at[place].clamp(-HELD, HELD).exp();
            own.hypot(floor[k])
        };
        let time_s = |k: usize| {
            let own = EXPECTED_TIME_S * at[SIZES + k].clamp(-HELD, HELD).exp();
            own.clamp(TIMES_S[0], TIMES_S[1])
        };
        Noise {
            size: std::array::from_fn(size),
            time_s: std::array::from_fn(time_s),
            of_wheels,
        }
    }
}
