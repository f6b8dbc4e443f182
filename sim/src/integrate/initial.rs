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

impl<S: Scalar> Robot<S> {
    /// Sets the velocity of `state`: of c along and across the body (m/s), yaw rate (rad/s), and
    /// wheel speeds (rad/s). Contacts with slip slide from then on; slip of wheels that cannot
    /// slide is projected out. With a motion law it is the velocity that the wheels give.
    pub fn set_motion(&self, state: &mut State<S>, velocity: [S; 3], wheel_speed: Pair<S>) {
        let [u, w, rate] = velocity;
        state.body.nu = Vector::from([u, w, rate, wheel_speed[0], wheel_speed[1]]);
        state.body.motor_speed = wheel_speed;
        let frictional = state.mode.frictional.iter();
        let at_rest: ConstraintSet = frictional
            .filter(|&constraint| slip_speed(self, state, constraint) <= GIVEN_SLIP_MIN)
            .collect();
        state.mode.active = at_rest;
        let change = ActiveSetChange {
            stopped: at_rest,
            ..ActiveSetChange::default()
        };
        update_active_set(self, state, [0.0, 0.0], &ActuatorOutput::zero(), change);
        state.body.motor_speed = [state.body.nu[3], state.body.nu[4]];
        state.body.carried = carried_at_rest(self, &state.body);
    }

    /// Sets `state` rolling without slip at forward speed `u` (m/s) and yaw rate `rate` (rad/s).
    pub fn set_rolling(&self, state: &mut State<S>, u: S, rate: S) {
        let turn = self.half_track * rate;
        let wheels = [(u + turn) / self.radius[0], (u - turn) / self.radius[1]];
        self.set_motion(state, [u, self.com_to_axle * rate, rate], wheels);
    }

    /// Sets delay and lag of `state` to their steady state under `command`.
    fn set_steady_command(&self, state: &mut State<S>, command: &Command<S>) {
        let (kind, command) = self.at_wheels(command);
        if self.actuator.delay_s.is_some() {
            state.history.reset(command);
        }
        let actuation = self
            .actuator
            .output(kind, command, &state.history, command, [0.0, 1.0]);
        state.body.lagged = actuation.lagged;
    }

    /// The state in which this robot goes on where another one, `before`, is, which has been commanded `command` last: place,
    /// motion and angles are the same, and what is left in delay, lag and gears is as far as this robot has them.
    pub fn carry_on(&self, before: (&Self, &State<S>), command: &Command<S>) -> State<S> {
        let (other, was) = before;
        let mut state = self.start(was.body.pose);
        state.body = was.body;
        state.external_force.clone_from(&was.external_force);
        self.set_steady_command(&mut state, command);
        if self.actuator.delay_s.is_some() && other.actuator.delay_s.is_some() {
            state.history = was.history.clone();
        }
        if other.actuator.lag_s.is_some() {
            state.body.lagged = was.body.lagged;
        }
        let had_gap = other.actuator.gap_rad.is_some();
        let motors = if had_gap {
            (was.body.motor_angle, was.body.motor_speed)
        } else {
            (was.wheel_angle(), was.wheel_speed())
        };
        state.body.motor_angle = motors.0;
        self.set_motion(&mut state, was.velocity(), was.wheel_speed());
        if !had_gap {
            let (kind, command) = self.at_wheels(command);
            close_gears(self, &mut state, kind, command);
        } else if self.actuator.gap_rad.is_some() {
            state.body.motor_speed = motors.1;
            state.mode.gear = was.mode.gear;
        }
        state
    }

    /// Sets delay, lag and gears of `state` to what `past` commands have left of them at `t_s` (s).
    /// Each entry is (from when (s), command), oldest first; the first is taken as steady.
    pub fn replay_commands(&self, state: &mut State<S>, past: &[(f64, Command<S>)], t_s: f64) {
        let Some((_, oldest)) = past.first() else {
            return;
        };
        self.set_steady_command(state, oldest);
        let ends = past.iter().skip(1).map(|(t_s, _)| *t_s).chain([t_s]);
        let mut last = (CommandKind::Torque, [S::constant(0.0); 2]);
        for ((since_s, command), end_s) in past.iter().zip(ends) {
            let (kind, command) = self.at_wheels(command);
            self.actuator.store(&mut state.history, *since_s, command);
            let mut from = *since_s;
            while from < end_s {
                let rest = [from, end_s - from];
                let change = self.actuator.next_change(&state.history, rest);
                let span = [from, change.unwrap_or(end_s) - from];
                let lagged = state.body.lagged;
                let actuation = self
                    .actuator
                    .output(kind, command, &state.history, lagged, span);
                state.body.lagged = actuation.lagged;
                last = (kind, actuation.end);
                from += span[1];
            }
        }
        let (kind, actuation) = last;
        close_gears(self, state, kind, actuation);
    }
}
