//! A force outside of the catalogue as a law: what it is wherever a simulation leads, so that it
//! predicts what it was not fitted to.

use slipstream_sim::{Command, Robot, State};

use crate::around::moved;
use crate::bench::{Bench, Node};
use crate::drivers::Sampled;
use crate::force::{Missing, shares};
use crate::search::deviance;
use crate::simulate::{asked, tracked};
use crate::track::{Sensor, Track};

/// How long a force is held between two looks at what it follows (s).
pub(crate) const HELD_S: f64 = 0.01;
/// Speed (m/s) and turn rate (rad/s) below which nothing moves that a force could act against.
const STILL: [f64; 2] = [2e-3, 2e-3];

/// A missing force that follows a variable.
#[derive(Debug, Clone)]
pub(crate) struct Law {
    missing: Missing,
    /// Wheel radius and half track of the nominal model (m).
    radius_m: f64,
    half_track_m: f64,
}

impl Law {
    pub(crate) fn new(bench: &Bench, missing: Missing) -> Self {
        let body = &bench.model.robot;
        Self {
            missing,
            radius_m: body.wheel_radius_m,
            half_track_m: body.half_track_m,
        }
    }

    /// Whether it leads nearer to what was measured than `node` is without it.
    pub(crate) fn holds(self, bench: &Bench, node: &Node) -> bool {
        let moved = moved(&bench.under(Some(self)), node);
        moved.is_some_and(|moved| deviance(&moved) < deviance(node))
    }

    /// Force along the body (N) and moment about the vertical (N m) at one moment.
    pub(crate) fn load(&self, sampled: &Sampled) -> [f64; 2] {
        let Missing {
            part,
            driver,
            against,
            weights,
            ..
        } = &self.missing;
        let still = sampled.v.abs() < STILL[0] && sampled.w.abs() < STILL[1];
        if *against && still {
            return [0.0; 2];
        }
        let force = driver.force(weights, sampled, *part);
        let lengths = [self.radius_m, self.half_track_m];
        shares(lengths, false, *part, *against, sampled).map(|share| share * force)
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
        let [r, b] = [self.radius_m, self.half_track_m];
        let angle = robot.seen_angle(state);
        let [u, _, rate] = state.velocity();
        let [v, w] = match track.of(Sensor::WheelAngle) {
            Some(_) => {
                let [right, left] = robot.seen_speed(state);
                [r * (right + left) / 2.0, r * (right - left) / (2.0 * b)]
            }
            None => [u, rate],
        };
        Sampled {
            t_s,
            v,
            w,
            angle: [angle[0] + offset[0], angle[1] + offset[1]],
            pose: tracked(track, robot, state.pose()),
            asked: asked(command, r, b),
            rested_s: f64::NAN,
        }
    }
}
