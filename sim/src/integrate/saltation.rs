//! Event at the end of a segment: the mode changes, and derivatives get the saltation correction.
//!
//! The derivative of a hybrid system through an event is not the derivative of the reset alone:
//! where a parameter shifts the event by δt, the motion before it lasts δt longer and the motion
//! after it begins δt later (Aizerman and Gantmacher, 1958; Leine and Nijmeijer, 2004). Both
//! motions are therefore followed for a δt whose value is zero and which carries derivatives alone.

use super::active_set::{ActiveSetChange, update_active_set};
use super::gears::update_gears;
use super::outcome::Event;
use super::prepare::acceleration_now;
use super::state::State;
use super::velocity_projection::project_velocity;
use crate::dynamics::motors::{MOTOR_SHARE, motor_damping, motor_torque};
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::scalar::{Pair, Scalar, Vector, heading};
use crate::robot::Robot;

/// Applies `event` at the end of `span`: changes gears and active set, resets the velocity and
/// corrects derivatives.
pub(super) fn apply_event<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
    event: &Event<S>,
) {
    let shift = event.time_shift(span[1]);
    let end = [span[0] + span[1], span[1]];
    if S::NDERIV > 0 {
        shift_along(robot, state, actuation, &event.before, shift);
    }
    if event.stopped.is_empty() && event.broken_away.is_empty() {
        // at a friction event the acceleration, and the torque in the gears, are not yet those
        // after it
        update_gears(robot, state);
    }
    if !event.stopped.is_empty() {
        // remove the slip that is left within the resolution of the segment
        let active = state.mode.active.union(event.stopped);
        let left = project_velocity(robot, state, active) - state.body.nu;
        state.body.nu += left.map(|left| S::constant(left.value()));
    }
    let change = ActiveSetChange {
        stopped: event.stopped,
        broken_away: event.broken_away,
    };
    update_active_set(robot, state, end, actuation, change);
    if S::NDERIV > 0 {
        let after = acceleration_now(robot, state, end, actuation);
        shift_along(robot, state, actuation, &after, -shift);
    }
}

/// Follows the motion with `acceleration` for a time `shift` (s).
fn shift_along<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    actuation: &ActuatorOutput<S>,
    acceleration: &Vector<S>,
    shift: S,
) {
    let kind = state.mode.kind;
    let torque = motor_torque(robot, kind, actuation.mean);
    let body = &mut state.body;
    let [cos, sin] = heading(body.pose[2]);
    let [along, across, rate] = body.velocity();
    body.pose[0] += (along * cos - across * sin) * shift;
    body.pose[1] += (along * sin + across * cos) * shift;
    body.pose[2] += rate * shift;
    body.nu += acceleration * shift;
    for (i, torque) in torque.into_iter().enumerate() {
        body.angle[i] += body.nu[3 + i] * shift;
        if state.mode.gear[i].is_engaged() {
            body.motor_speed[i] = body.nu[3 + i];
        } else if kind != CommandKind::Speed {
            let net = torque - motor_damping(robot, kind) * body.motor_speed[i];
            body.motor_speed[i] += net / (robot.wheel_inertia * MOTOR_SHARE) * shift;
        }
        body.motor_angle[i] += body.motor_speed[i] * shift;
    }
}
