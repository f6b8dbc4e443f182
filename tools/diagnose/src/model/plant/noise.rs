//! Noise of the filter over the plant as fitted parameters: logs of sizes and of correlation times.
//!
//! A size is never below its floor, the difference between two integrators of one model: of a disturbance
//! that is not there the likelihood says nothing, and its prior holds the logarithm.

use super::machine::Machine;
use crate::estimate::Prior;
use crate::filter::dynamic::{Noise, Sensor};

/// Where sizes are expected for a robot of 1.6 kg: surge force (N), yaw moment (N m), creep along (m/s), about
/// (rad/s) and across (m/s), torque of a wheel (N m); and of any robot, how far a stamp is off that was rounded to a
/// millisecond (s), and shares by which readings of wheels, poses and inertial sensor err beyond what is known.
const EXPECTED: [f64; SIZES] = [0.05, 0.002, 1e-3, 3e-3, 1e-3, 3e-3, 3e-4, 1.0, 1.0, 1.0];
/// A stamp that is exact (s): a tenth of what most logs round to; and the share of an error that is none.
const EXACT_S: f64 = 1e-5;
const NOTHING: f64 = 0.03;
const EXPECTED_TIME_S: f64 = 0.3;
/// Standard deviations of the logs of sizes, about their floors, and of times: a size is known to a factor of 50, a time
/// to lie between some hundredths of a second and some seconds.
const DEVIATION: f64 = 4.0;
const TIME_DEVIATION: f64 = 1.2;
/// Logs beyond which a size is held.
const HELD: f64 = 9.0;
/// Shortest and longest correlation time (s).
const TIMES_S: [f64; 2] = [0.01, 10.0];
/// Torque of a wheel, in the place of creep along and about where wheels can slide.
const TORQUE: usize = 5;
/// The error of a stamp, and the first of the shares beyond known errors.
const JITTER: usize = 6;
const BEYOND: usize = 7;
/// Share of the sizes that are expected below which a filter that follows changes takes none.
const HUMBLE: f64 = 0.3;
/// Sizes and times.
pub(super) const SIZES: usize = 10;
const TIMES: usize = 3;
pub(super) const COUNT: usize = SIZES + TIMES;

impl Machine {
    /// Those that the runs tell of: creep where a heading or a place is measured, errors of stamps where these are uneven,
    /// and of readings where they are guessed.
    pub(super) fn told_noise(&self) -> impl Iterator<Item = usize> {
        let heading = self.measures(Sensor::Pose, 2);
        let place = self.has_pose();
        let guessed = self.guessed();
        (0..COUNT).filter(move |index| match *index {
            2 | 4 => place,
            3 => heading,
            JITTER => self.is_uneven,
            BEYOND..SIZES => guessed[*index - BEYOND],
            _ => true,
        })
    }

    /// The prior of each noise parameter.
    pub(super) fn noise_priors(&self) -> Vec<Prior> {
        let [rolling, sliding] = [false, true].map(|of_wheels| self.floor(of_wheels));
        let floors = [0, 1, 2, 3, 4].map(|place| rolling[place]);
        let sizes = floors
            .into_iter()
            .chain([sliding[2], EXACT_S, NOTHING, NOTHING, NOTHING])
            .enumerate();
        let sizes = sizes.map(|(place, floor)| Prior {
            mean: (floor / self.expected(place)).ln(),
            deviation: DEVIATION,
            has_tails: false,
        });
        let times = Prior {
            mean: 0.0,
            deviation: TIME_DEVIATION,
            has_tails: false,
        };
        sizes.chain([times; TIMES]).collect()
    }

    /// The size of a disturbance that is expected.
    fn expected(&self, place: usize) -> f64 {
        let of_force = place < 2 || place == TORQUE;
        let scale = if of_force { self.mass_share() } else { 1.0 };
        scale * EXPECTED[place]
    }

    /// The same noise, but no disturbance below what is expected of a robot: a filter that believes itself less follows what
    /// changes.
    pub(crate) fn humbled(&self, own: &Noise) -> Noise {
        let expected = self.noise(&[0.0; COUNT], own.of_wheels);
        Noise {
            size: std::array::from_fn(|k| own.size[k].max(HUMBLE * expected.size[k])),
            ..*own
        }
    }

    /// Noise at these parameters.
    pub(crate) fn noise(&self, at: &[f64], of_wheels: bool) -> Noise {
        let floor = self.floor(of_wheels);
        let places = if of_wheels {
            [0, 1, TORQUE, TORQUE, 4]
        } else {
            [0, 1, 2, 3, 4]
        };
        let own = |place: usize| self.expected(place) * at[place].clamp(-HELD, HELD).exp();
        let size = |k: usize| own(places[k]).hypot(floor[k]);
        let time_s = |k: usize| {
            let own = EXPECTED_TIME_S * at[SIZES + k].clamp(-HELD, HELD).exp();
            own.clamp(TIMES_S[0], TIMES_S[1])
        };
        let guessed = self.guessed();
        let where_told = |told: bool, place: usize| if told { own(place) } else { 0.0 };
        Noise {
            size: std::array::from_fn(size),
            time_s: std::array::from_fn(time_s),
            of_wheels,
            jitter_s: where_told(self.is_uneven, JITTER),
            beyond: std::array::from_fn(|k| where_told(guessed[k], BEYOND + k)),
        }
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;
    use crate::predict::fixture;

    /// A machine whose rows were stamped by `stamp`.
    fn stamped(stamp: fn(f64) -> f64) -> Machine {
        let model = RobotModel::default();
        let mut track = fixture::driven(&model, 4.0, fixture::gentle);
        for series in &mut track.series {
            series.rows.iter_mut().for_each(|row| row.0 = stamp(row.0));
        }
        Machine::new(vec![track], model, &[])
    }

    #[test]
    fn stamps_err_where_they_are_uneven() {
        let told = |own: &Machine| own.told_noise().any(|index| index == JITTER);
        let grid = stamped(|t_s| t_s);
        assert!(!told(&grid));
        assert_eq!(grid.noise(&[0.0; COUNT], false).jitter_s, 0.0);
        // 20 ms and a third, in whole milliseconds
        let rounded = stamped(|t_s| (t_s / 0.02 * 20.333).floor() * 1e-3);
        assert!(told(&rounded));
        let jitter_s = rounded.noise(&[0.0; COUNT], false).jitter_s;
        assert_eq!(jitter_s, EXPECTED[JITTER]);
        // a wheel at 10 rad/s is read 3 mrad beside its angle
        let noise = rounded.noise(&[0.0; COUNT], false);
        let variance = noise.variance(Sensor::WheelAngle, &[1e-6; 3], &[10.0, 0.0, 0.0]);
        assert!((variance[0] - (1e-6 + 9e-6)).abs() < 1e-12);
        assert_eq!(variance[1], 1e-6);
    }

    #[test]
    fn readings_err_beyond_what_is_known_where_that_is_guessed() {
        let model = RobotModel::default();
        let mut track = fixture::driven(&model, 4.0, fixture::gentle);
        track.series[0].is_guessed = true;
        let machine = Machine::new(vec![track], model, &[]);
        let told: Vec<usize> = machine.told_noise().filter(|own| *own >= BEYOND).collect();
        assert_eq!(told[0], BEYOND);
        assert!(!told.contains(&(BEYOND + 1)));
        let noise = machine.noise(&[0.0; COUNT], false);
        assert_eq!(noise.beyond, [EXPECTED[BEYOND], 0.0, 0.0]);
    }

    #[test]
    fn a_heading_without_places_is_measured() {
        let model = RobotModel::default();
        let mut track = fixture::driven(&model, 4.0, fixture::gentle);
        for (_, pose) in &mut track.series[1].rows {
            (pose[0], pose[1]) = (f64::NAN, f64::NAN);
        }
        let machine = Machine::new(vec![track], model, &[]);
        assert!(!machine.has_pose() && machine.measures(Sensor::Pose, 2));
        let told: Vec<usize> = machine
            .told_noise()
            .filter(|own| (2..TORQUE).contains(own))
            .collect();
        assert_eq!(told, [3]);
        let pass = machine.pass(Vec::new(), machine.noise(&[0.0; COUNT], false));
        assert!(pass.unwrap().whitened.iter().all(|own| own.is_finite()));
    }
}
