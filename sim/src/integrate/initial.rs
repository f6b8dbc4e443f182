//! Initial conditions: motion and the memory of the actuators.

use super::active_set::ActiveSetChange;
use super::state::State;
use crate::integrate::active_set::{sliding_speed, update_active_set};
use crate::integrate::events::motor_effort;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::{Command, CommandKind};
use crate::parts::friction_elements::{Element, ElementSet};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::GIVEN_SLIP_MIN;
use crate::robot::Robot;
use crate::robot::body::Gear;

impl<S: Scalar> Robot<S> {
    /// Sets `state` in motion: velocity of c along and across the body (m/s) and yaw rate (rad/s),
    /// wheel speeds (rad/s). What slides then, slides; what cannot slide keeps what rolling leaves.
    pub fn set_motion(&self, state: &mut State<S>, velocity: [S; 3], wheel_speed: Pair<S>) {
        let [u, w, rate] = velocity;
        state.body.nu = Vector::from([u, w, rate, wheel_speed[0], wheel_speed[1]]);
        state.body.motor_speed = wheel_speed;
        let loose = state.mode.loose;
        let stands = |element: &Element| sliding_speed(self, state, *element) <= GIVEN_SLIP_MIN;
        let standing = loose
            .iter()
            .filter(stands)
            .fold(ElementSet::default(), ElementSet::with);
        state.mode.held = standing;
        let change = ActiveSetChange {
            stopped: standing,
            ..ActiveSetChange::default()
        };
        update_active_set(self, state, [0.0, 0.0], &ActuatorOutput::none(), change);
        state.body.motor_speed = [state.body.nu[3], state.body.nu[4]];
    }

    /// Sets `state` rolling on both wheels at forward speed `u` (m/s) and yaw rate `rate` (rad/s).
    pub fn set_rolling(&self, state: &mut State<S>, u: S, rate: S) {
        let turn = self.half_track * rate;
        let wheels = [(u + turn) / self.radius[0], (u - turn) / self.radius[1]];
        self.set_motion(state, [u, self.com_to_axle * rate, rate], wheels);
    }

    /// Lets `command` have acted since long ago: nothing is left of others in delay and lag.
    pub fn set_steady_command(&self, state: &mut State<S>, command: &Command<S>) {
        let (kind, command) = command.at_wheels(self.nominal);
        if self.drive.delay_s.is_some() {
            state.history.clear();
            state.history.push_back((f64::NEG_INFINITY, command));
        }
        let supply = self
            .drive
            .supply(kind, command, &state.history, command, [0.0, 1.0]);
        state.body.lagged = supply.lagged;
    }

    /// Lets commands have acted until `t_s`, each (command, from when (s)), oldest first: delay, lag
    /// and play are as they leave them. The first of them counts as having acted since long ago.
    pub fn replay_commands(&self, state: &mut State<S>, past: &[(f64, Command<S>)], t_s: f64) {
        let Some((_, oldest)) = past.first() else {
            return;
        };
        self.set_steady_command(state, oldest);
        let ends = past.iter().skip(1).map(|(t_s, _)| *t_s).chain([t_s]);
        let mut reached = (CommandKind::Torque, [S::constant(0.0); 2]);
        for ((since_s, command), end_s) in past.iter().zip(ends) {
            let (kind, command) = command.at_wheels(self.nominal);
            store_command(self, state, *since_s, command);
            let mut from = *since_s;
            while from < end_s {
                let change = self.drive.next_change(&state.history, [from, end_s - from]);
                let span = [from, change.unwrap_or(end_s) - from];
                let lagged = state.body.lagged;
                let supply = self
                    .drive
                    .supply(kind, command, &state.history, lagged, span);
                state.body.lagged = supply.lagged;
                reached = (kind, supply.end);
                from += span[1];
            }
        }
        let (kind, supply) = reached;
        close_gears(self, state, kind, supply);
    }
}

/// Motors that push their wheels lie against them.
fn close_gears<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    kind: CommandKind,
    supply: Pair<S>,
) {
    let Some(gap_rad) = robot.drive.gap_rad else {
        return;
    };
    let push = motor_effort(robot, kind, supply, [state.body.nu[3], state.body.nu[4]]);
    for (i, push) in push.into_iter().enumerate() {
        let side = match push.value() {
            v if v > 0.0 => Gear::Forward,
            v if v < 0.0 => Gear::Backward,
            _ => continue,
        };
        let sign = if side == Gear::Forward { 0.5 } else { -0.5 };
        state.mode.gear[i] = side;
        state.body.motor_angle[i] = state.body.angle[i] + gap_rad * sign;
        state.body.motor_speed[i] = state.body.nu[3 + i];
    }
}

/// Keeps a command for as long as the delay needs it.
pub(crate) fn store_command<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    t_s: f64,
    command: Pair<S>,
) {
    let Some(delay_s) = robot.drive.delay_s else {
        return;
    };
    while state
        .history
        .get(1)
        .is_some_and(|(next_s, _)| next_s + delay_s.value() < t_s)
    {
        state.history.pop_front();
    }
    if state
        .history
        .back()
        .is_none_or(|(_, last)| *last != command)
    {
        state.history.push_back((t_s, command));
    }
}
