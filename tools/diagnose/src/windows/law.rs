//! A force outside of the catalogue as a law: what it is wherever a simulation leads, so that it
//! predicts what it was not fitted to. Where wheels turn as they are told it is a motion, and they are
//! told that as well.

use slipstream_sim::{Command, Robot, State};

use crate::windows::bench::Bench;
use crate::windows::force::{Missing, acts};
use crate::windows::sampled::Sampled;
use crate::windows::simulate::{asked, tracked};
use crate::windows::track::{Sensor, Track, geometry};

/// How long a force is held between two looks at what it follows (s).
pub(crate) const HELD_S: f64 = 0.01;

/// A missing force that follows a variable.
#[derive(Debug, Clone)]
pub(crate) struct Law {
    missing: Missing,
    /// Wheels turn as they are told.
    of_motion: bool,
    /// Wheel radius, half track and the way from the axle to the centre of mass of the nominal model (m).
    lengths_m: [f64; 3],
}

impl Law {
    pub(crate) fn new(bench: &Bench, missing: Missing) -> Self {
        Self {
            missing,
            of_motion: bench.lacks_motion(),
            lengths_m: geometry(&bench.model.robot),
        }
    }

    /// What a command becomes at one moment, and the force along the body (N) and moment about the
    /// vertical (N m) beside it.
    pub(crate) fn acts(&self, command: &Command, sampled: &Sampled) -> (Command, Option<[f64; 2]>) {
        let amount = self.amount(sampled);
        if !self.of_motion {
            return (*command, Some(amount));
        }
        let [v_m_s, w_rad_s] = amount;
        let twist = Command::Twist { v_m_s, w_rad_s };
        let [r, b, _] = self.lengths_m;
        let more = asked(&twist, r, b);
        let told = Command::Speed {
            right_rad_s: sampled.asked[0] + more[0],
            left_rad_s: sampled.asked[1] + more[1],
        };
        (told, None)
    }

    /// Force along the body (N) and moment about the vertical (N m) at one moment, or speed (m/s) and
    /// turn rate (rad/s).
    fn amount(&self, sampled: &Sampled) -> [f64; 2] {
        let Missing {
            part,
            driver,
            against,
            weights,
            ..
        } = &self.missing;
        if *against && sampled.stands() {
            return [0.0; 2];
        }
        let all = acts(
            self.lengths_m,
            self.of_motion,
            driver,
            *part,
            *against,
            sampled,
        );
        all.into_iter().fold([0.0; 2], |sum, (function, acts)| {
            [0, 1].map(|i| sum[i] + weights[function] * acts[i])
        })
    }

    /// What a simulation knows of a moment that a measurement would; how long the robot has stood is
    /// not known there.
    pub(crate) fn sampled(
        &self,
        (track, robot): (&Track, &Robot),
        state: &State,
        offset: [f64; 2],
        t_s: f64,
        command: &Command,
    ) -> Sampled {
        let [r, b, _] = self.lengths_m;
        let angle = robot.measured_angle(state);
        let [u, _, rate] = state.velocity();
        let asked = asked(command, r, b);
        let [v, w] = match track.of(Sensor::WheelAngle) {
            _ if self.of_motion => robot.odometry(asked),
            Some(_) => robot.odometry(robot.measured_speed(state)),
            None => [u, rate],
        };
        Sampled {
            t_s,
            v,
            w,
            angle: [angle[0] + offset[0], angle[1] + offset[1]],
            pose: tracked(track, robot, state.pose()),
            asked,
            rested_s: f64::NAN,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use slipstream_bus::RobotModel;

    use super::*;
    use crate::windows::around::moved;
    use crate::windows::bench::{FULL, Node};
    use crate::windows::drivers::Driver;
    use crate::windows::fixture;
    use crate::windows::force::{self, Part};

    const GRADE: f64 = 0.02;

    /// A robot on a slope, the level model of it, and what the weight pulls along the body as a function
    /// of the heading φ: m g sin(atan(grade)) cos φ.
    pub(crate) fn slope() -> (Bench, Node, Missing) {
        let model = RobotModel::default();
        let downhill = [("grade", GRADE), ("downhill_rad", 0.0)];
        let truth = model.clone().with("floor_slope", &downhill);
        let body = &model.robot;
        let mass = body.body_mass_kg.unwrap() + 2.0 * body.wheel_mass_kg.unwrap();
        let bench = fixture::bench(fixture::driven(&truth, 10.0, fixture::gentle), model);
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[], &starts, FULL).unwrap();
        let answers = force::answers(&bench, &node, 1.0).unwrap();
        let drivers = Driver::all(&force::samples(&answers));
        let driver = drivers.into_iter().find(|d| d.name == "heading").unwrap();
        let mut weights = vec![0.0; driver.functions()];
        weights[2] = mass * 9.81 * GRADE.atan().sin();
        let missing = Missing {
            part: Part::Longitudinal,
            driver,
            against: false,
            weights,
            deviance: 0.0,
        };
        (bench, node, missing)
    }

    /// The law is held for 10 ms, so that it lags by 5 ms, in which the robot turns by some hundredths of
    /// a radian at most: that share of what was missing is left.
    #[test]
    fn what_is_missing_predicts_as_a_law() {
        let (bench, node, missing) = slope();
        let before = bench.worst(&node).1;
        assert!(before > 30.0, "{before}");
        let law = Law::new(&bench, missing);
        let moved = moved(&bench.under(Some(law)), &node).unwrap();
        let after = bench.worst(&moved).1;
        assert!(after < 0.03 * before, "{after} of {before}");
    }

    #[test]
    fn nothing_acts_against_a_rest() {
        let (bench, _, mut missing) = slope();
        let track = &bench.tracks[0];
        let mut sampled = Sampled::new(&bench, track, 1.0, [0.0; 3]);
        (sampled.v, sampled.w, sampled.pose[2]) = (0.1, 0.0, 0.0);
        missing.against = true;
        let force = missing.weights[2];
        let law = Law::new(&bench, missing);
        assert_eq!(law.amount(&sampled)[0], -force);
        sampled.v = -0.1;
        assert_eq!(law.amount(&sampled)[0], force);
        sampled.v = 1e-3;
        assert_eq!(law.amount(&sampled), [0.0; 2]);
    }
}
