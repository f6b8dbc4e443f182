//! Initial conditions: velocity, and what past commands have left in delay, lag and gears.

use super::active_set::{ActiveSetChange, slip_speed, update_active_set};
use super::carried::carried_at_rest;
use super::gears::close_gears;
use super::state::State;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::{Command, CommandKind};
use crate::parts::friction_constraints::ConstraintSet;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::GIVEN_SLIP_MIN;
use crate::robot::Robot;

/// As [`Robot::set_motion`] describes it.
pub(super) fn set_motion<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    velocity: [S; 3],
    wheel_speed: Pair<S>,
) {
    let [u, w, rate] = velocity;
    state.body.nu = Vector::from([u, w, rate, wheel_speed[0], wheel_speed[1]]);
    state.body.motor_speed = wheel_speed;
    let frictional = state.mode.frictional.iter();
    let at_rest: ConstraintSet = frictional
        .filter(|&constraint| slip_speed(robot, state, constraint) <= GIVEN_SLIP_MIN)
        .collect();
    state.mode.active = at_rest;
    let change = ActiveSetChange {
        stopped: at_rest,
        ..ActiveSetChange::default()
    };
    update_active_set(robot, state, [0.0, 0.0], &ActuatorOutput::zero(), change);
    state.body.motor_speed = [state.body.nu[3], state.body.nu[4]];
    state.body.carried = carried_at_rest(robot, &state.body);
}

/// Sets delay and lag of `state` to their steady state under `command`.
fn set_steady_command<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, command: &Command<S>) {
    let (kind, command) = command.at_wheels(robot.nominal);
    if robot.actuator.delay_s.is_some() {
        state.history.reset(command);
    }
    let actuation = robot
        .actuator
        .output(kind, command, &state.history, command, [0.0, 1.0]);
    state.body.lagged = actuation.lagged;
}

/// As [`Robot::replay_commands`] describes it.
pub(super) fn replay_commands<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    past: &[(f64, Command<S>)],
    t_s: f64,
) {
    let Some((_, oldest)) = past.first() else {
        return;
    };
    set_steady_command(robot, state, oldest);
    let ends = past.iter().skip(1).map(|(t_s, _)| *t_s).chain([t_s]);
    let mut last = (CommandKind::Torque, [S::constant(0.0); 2]);
    for ((since_s, command), end_s) in past.iter().zip(ends) {
        let (kind, command) = command.at_wheels(robot.nominal);
        robot.actuator.store(&mut state.history, *since_s, command);
        let mut from = *since_s;
        while from < end_s {
            let rest = [from, end_s - from];
            let change = robot.actuator.next_change(&state.history, rest);
            let span = [from, change.unwrap_or(end_s) - from];
            let lagged = state.body.lagged;
            let actuation = robot
                .actuator
                .output(kind, command, &state.history, lagged, span);
            state.body.lagged = actuation.lagged;
            last = (kind, actuation.end);
            from += span[1];
        }
    }
    let (kind, actuation) = last;
    close_gears(robot, state, kind, actuation);
}
