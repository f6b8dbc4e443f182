//! From velocities to pose and angles.

use crate::attempt::MOTOR_SHARE;
use crate::command::CommandKind;
use crate::drive::Supply;
use crate::robot::Robot;
use crate::rows::Element;
use crate::scalar::{Pair, Scalar, Vector, heading};
use crate::state::{Body, State};

impl<S: Scalar> Robot<S> {
    /// Moves pose, wheel angles and motors from `state` to the velocities that `body` already has.
    /// `torque` is the motors', without what they lose with speed.
    pub(crate) fn travel(
        &self,
        state: &State<S>,
        body: &mut Body<S>,
        over_s: f64,
        supply: &Supply<S>,
        torque: Pair<S>,
    ) {
        let from = &state.body;
        let mut mean = (from.nu + body.nu) * S::constant(0.5);
        let rigid = state.mode.kind == CommandKind::Speed;
        if rigid && self.drive.lag_s.is_some() {
            // the mean of an exponential is not the mean of its ends
            for (i, axle) in Element::AXLES.into_iter().enumerate() {
                let bent = supply.mean[i] - (supply.start[i] + supply.end[i]) * 0.5;
                mean += state.operator.response(axle.rows()[0], bent);
            }
        }
        body.pose = advance_pose(from.pose, &mean, &(body.nu - from.nu), over_s);
        body.angle = [0, 1].map(|i| from.angle[i] + mean[3 + i] * over_s);
        let damping = self.motor_damping(state.mode.kind);
        if self.drive.gap_rad.is_none() && !rigid {
            body.torque = [0, 1].map(|i| torque[i] - damping * mean[3 + i]);
            return;
        }
        for i in 0..2 {
            let engaged = state.mode.gear[i].is_engaged();
            if engaged {
                body.motor_speed[i] = body.nu[3 + i];
                body.motor_angle[i] = from.motor_angle[i] + mean[3 + i] * over_s;
                body.torque[i] = if rigid {
                    body.acceleration[3 + i] * self.wheel_inertia
                        + self.radius[i] * body.contact.along_n[i]
                } else {
                    torque[i] - damping * mean[3 + i]
                };
                continue;
            }
            let speed = if rigid {
                supply.end[i]
            } else {
                let inertia = self.wheel_inertia * MOTOR_SHARE;
                let gain = (inertia + damping * (0.5 * over_s)).recip();
                from.motor_speed[i] + (torque[i] - damping * from.motor_speed[i]) * gain * over_s
            };
            let mean = if rigid {
                supply.mean[i]
            } else {
                (from.motor_speed[i] + speed) * 0.5
            };
            body.motor_speed[i] = speed;
            body.motor_angle[i] = from.motor_angle[i] + mean * over_s;
            body.torque[i] = S::constant(0.0);
        }
    }
}

/// The pose after a velocity in the body frame of mean `mean` that changes by `change`, linearly.
///
/// The displacement is that in the frame at half the turn, ∫ R(δ τ) (v + Δv τ) dτ over τ from −½ to
/// ½, to the fourth order in the turn δ: an arc of 1 ms is exact to rounding.
#[inline]
pub(crate) fn advance_pose<S: Scalar>(
    pose: [S; 3],
    mean: &Vector<S>,
    change: &Vector<S>,
    over_s: f64,
) -> [S; 3] {
    let turn = mean[2] * over_s;
    let square = turn * turn;
    let chord = (square * (1.0 / 1920.0) - 1.0 / 24.0) * square + 1.0;
    let skew = turn * (1.0 / 12.0);
    let along = mean[0] * chord - change[1] * skew;
    let across = mean[1] * chord + change[0] * skew;
    let [cos, sin] = heading(pose[2] + turn * 0.5);
    [
        pose[0] + (along * cos - across * sin) * over_s,
        pose[1] + (along * sin + across * cos) * over_s,
        pose[2] + turn,
    ]
}
