//! Kinematics: pose, wheel angles and motors from the velocities at both ends of a step.

use super::carried::carried_velocity;
use super::state::State;
use crate::dynamics::motors::{MOTOR_SHARE, motor_damping};
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::FrictionConstraint;
use crate::parts::pose::advance_pose;
use crate::parts::scalar::{Pair, Scalar, Vector, heading};
use crate::robot::Robot;
use crate::robot::body::{Body, Carried};

/// Advances pose, wheel angles and motors from `state` over `span` = [start (s), length (s)] to the
/// velocity that `body` already has. `torque` is that of the motors, without what they lose with speed (N m).
pub(super) fn advance_configuration<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    body: &mut Body<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
    torque: Pair<S>,
) {
    let from = &state.body;
    let over_s = span[1];
    let mut mean = (from.nu + body.nu) * S::constant(0.5);
    let prescribed = state.mode.kind == CommandKind::Speed;
    if prescribed && robot.actuator.lag_s.is_some() {
        // the mean of an exponential is not the mean of its ends
        for (i, axle) in FrictionConstraint::AXLES.into_iter().enumerate() {
            let excess = actuation.mean[i] - (actuation.start[i] + actuation.end[i]) * 0.5;
            mean += state.dynamics.response(axle.rows()[0], excess);
        }
    }
    let change = body.nu - from.nu;
    if robot.effects.has_carry {
        carry(robot, from, body, [&mean, &change], span);
    } else {
        body.pose = advance_pose(from.pose, &mean, &change, over_s);
    }
    body.angle = [0, 1].map(|i| from.angle[i] + mean[3 + i] * over_s);
    let damping = motor_damping(robot, state.mode.kind);
    if robot.actuator.gap_rad.is_none() && !prescribed {
        body.torque = [0, 1].map(|i| torque[i] - damping * mean[3 + i]);
        return;
    }
    for i in 0..2 {
        if state.mode.gear[i].is_engaged() {
            body.motor_speed[i] = body.nu[3 + i];
            body.motor_angle[i] = from.motor_angle[i] + mean[3 + i] * over_s;
            body.torque[i] = if prescribed {
                body.acceleration[3 + i] * robot.wheel_inertia
                    + robot.radius[i] / robot.travel[i] * body.contact.longitudinal_n[i]
            } else {
                torque[i] - damping * mean[3 + i]
            };
            continue;
        }
        let speed = if prescribed {
            actuation.end[i]
        } else {
            let inertia = robot.wheel_inertia * MOTOR_SHARE;
            let gain = (inertia + damping * (0.5 * over_s)).recip();
            from.motor_speed[i] + (torque[i] - damping * from.motor_speed[i]) * gain * over_s
        };
        let mean = if prescribed {
            actuation.mean[i]
        } else {
            (from.motor_speed[i] + speed) * 0.5
        };
        body.motor_speed[i] = speed;
        body.motor_angle[i] = from.motor_angle[i] + mean * over_s;
        body.torque[i] = S::constant(0.0);
    }
}

/// Advances the pose with what effects add to the motion of the wheels: the `mean` velocity with its
/// `change` over `span`, by the midpoint rule.
fn carry<S: Scalar>(
    robot: &Robot<S>,
    from: &Body<S>,
    body: &mut Body<S>,
    [mean, change]: [&Vector<S>; 2],
    [t_s, over_s]: Pair<f64>,
) {
    let start = carried_velocity(robot, &from.nu, from.pose, [t_s, 0.0]);
    let half_s = over_s / 2.0;
    let early = from.nu + start;
    let middle = advance_pose(from.pose, &early, &Vector::zeros(), half_s);
    let added = carried_velocity(robot, mean, middle, [t_s, over_s]);
    body.pose = advance_pose(from.pose, &(mean + added), change, over_s);
    let end = carried_velocity(robot, &body.nu, body.pose, [t_s + over_s, 0.0]);
    let rate = (end - start) * S::constant(over_s.recip());
    body.carried = Some(Carried {
        velocity: [end[0], end[1], end[2]],
        rate: [rate[0], rate[1], rate[2]],
    });
}

/// The pose after `over_s` (s) at which forces of the second stage are taken, where the velocity is
/// `guess`. Its position follows only where an effect may depend on it.
#[inline]
pub(in crate::integrate) fn predicted_pose<S: Scalar>(
    robot: &Robot<S>,
    from: &Body<S>,
    guess: &Vector<S>,
    over_s: f64,
) -> [S; 3] {
    let [x, y, yaw] = from.pose;
    let end = yaw + (from.nu[2] + guess[2]) * (0.5 * over_s);
    if !robot.effects.has_force {
        return [x, y, end];
    }
    let [cos, sin] = heading(yaw);
    [
        x + (from.nu[0] * cos - from.nu[1] * sin) * over_s,
        y + (from.nu[0] * sin + from.nu[1] * cos) * over_s,
        end,
    ]
}
