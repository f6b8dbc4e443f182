//! From velocities to pose and angles.

use super::state::State;
use crate::dynamics::inertia::motor_damping;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::Element;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar};
use crate::parts::tolerances::MOTOR_SHARE;
use crate::robot::Robot;
use crate::robot::body::Body;

/// Moves pose, wheel angles and motors from `state` to the velocities that `body` already has.
/// `torque` is the motors', without what they lose with speed.
pub(crate) fn advance_configuration<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    body: &mut Body<S>,
    over_s: f64,
    supply: &ActuatorOutput<S>,
    torque: Pair<S>,
) {
    let from = &state.body;
    let mut mean = (from.nu + body.nu) * S::constant(0.5);
    let rigid = state.mode.kind == CommandKind::Speed;
    if rigid && robot.drive.lag_s.is_some() {
        // the mean of an exponential is not the mean of its ends
        for (i, axle) in Element::AXLES.into_iter().enumerate() {
            let bent = supply.mean[i] - (supply.start[i] + supply.end[i]) * 0.5;
            mean += state.operator.response(axle.rows()[0], bent);
        }
    }
    body.pose = advance_pose(from.pose, &mean, &(body.nu - from.nu), over_s);
    body.angle = [0, 1].map(|i| from.angle[i] + mean[3 + i] * over_s);
    let damping = motor_damping(robot, state.mode.kind);
    if robot.drive.gap_rad.is_none() && !rigid {
        body.torque = [0, 1].map(|i| torque[i] - damping * mean[3 + i]);
        return;
    }
    for i in 0..2 {
        let engaged = state.mode.gear[i].is_engaged();
        if engaged {
            body.motor_speed[i] = body.nu[3 + i];
            body.motor_angle[i] = from.motor_angle[i] + mean[3 + i] * over_s;
            body.torque[i] = if rigid {
                body.acceleration[3 + i] * robot.wheel_inertia
                    + robot.radius[i] * body.contact.along_n[i]
            } else {
                torque[i] - damping * mean[3 + i]
            };
            continue;
        }
        let speed = if rigid {
            supply.end[i]
        } else {
            let inertia = robot.wheel_inertia * MOTOR_SHARE;
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
