//! The step: smooth pieces between the instants at which something sticks, slips or meets.

use super::active_set::ActiveSetChange;
use super::outcome::{Event, StepOutcome};
use super::state::State;
use crate::dynamics::inertia::{motor_damping, motor_torque};
use crate::integrate::active_set::{
    acceleration_now, prepare_dynamics, project_velocity, update_active_set,
};
use crate::integrate::events::update_gears;
use crate::integrate::initial::store_command;
use crate::integrate::trial_step::trial_step;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::{Command, CommandKind};
use crate::parts::friction_elements::{Element, ElementSet};
use crate::parts::scalar::{Pair, Scalar, Vector, heading};
use crate::parts::tolerances::{GIVEN_SLIP_MIN, MOTOR_SHARE};
use crate::robot::Robot;

/// One piece of a step.
#[derive(Debug, Clone, Copy)]
struct Segment<S> {
    /// From when and how long (s).
    span: Pair<f64>,
    command: Pair<S>,
    depth: u32,
}

impl<S: Scalar> Robot<S> {
    /// Moves `state` on by `dt_s` from time `t_s` under `command`, which acts all the time. No
    /// allocation, unless a delay line has to hold more than a thousand changes of command.
    ///
    /// Second order in `dt_s`; a change between rolling and sliding is found inside the step.
    pub fn step(&self, state: &mut State<S>, t_s: f64, dt_s: f64, command: &Command<S>) {
        let (kind, command) = command.at_wheels(self.nominal);
        if kind == CommandKind::Torque
            && state.load.is_none()
            && let Some(short) = &state.short
            && short.step(self, &mut state.body, dt_s, command)
        {
            return;
        }
        if kind != state.mode.kind {
            state.mode.kind = kind;
            update_active_set(
                self,
                state,
                [t_s, dt_s],
                &ActuatorOutput::none(),
                ActiveSetChange::default(),
            );
        }
        store_command(self, state, t_s, command);
        let mut from = t_s;
        let mut events = self.tolerances.events;
        loop {
            let rest = t_s + dt_s - from;
            let change = self.drive.next_change(&state.history, [from, rest]);
            let over = change.map_or(rest, |at| at - from);
            let piece = Segment {
                span: [from, over],
                command,
                depth: 0,
            };
            if kind == CommandKind::Speed {
                jump_to_speed(self, state, &piece);
            }
            advance(self, state, piece, &mut events);
            match change {
                Some(at) => from = at,
                None => return,
            }
        }
    }
}

/// Exact wheel speeds jump with their command. Wheels that can slip do so; a robot that cannot
/// jumps along.
fn jump_to_speed<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, piece: &Segment<S>) {
    let supply = actuator_output(robot, state, piece);
    prepare_dynamics(robot, state, piece.span, &supply);
    let zero = S::constant(0.0);
    let mut slips = false;
    let mut moved = Vector::from([zero; 5]);
    for (i, axle) in Element::AXLES.into_iter().enumerate() {
        if !state.mode.gear[i].is_engaged() {
            continue;
        }
        let change = supply.start[i] - state.body.nu[3 + i];
        state.body.nu[3 + i] = supply.start[i];
        let rolls = state.mode.grip[i].is_none();
        if rolls {
            moved += state.operator.response(axle.rows()[0], change);
            moved[3 + i] -= change;
        }
        slips |= !rolls && change.value().abs() > GIVEN_SLIP_MIN;
    }
    state.body.nu += moved;
    if slips {
        update_active_set(
            robot,
            state,
            piece.span,
            &supply,
            ActiveSetChange::default(),
        );
    }
}

fn actuator_output<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    piece: &Segment<S>,
) -> ActuatorOutput<S> {
    let (kind, lagged) = (state.mode.kind, state.body.lagged);
    robot
        .drive
        .supply(kind, piece.command, &state.history, lagged, piece.span)
}

/// One piece: taken as it is if nothing changes in it, else halved until the change stands
/// between two pieces.
fn advance<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, piece: Segment<S>, events: &mut u32) {
    let mut regrouped = false;
    loop {
        let supply = actuator_output(robot, state, &piece);
        prepare_dynamics(robot, state, piece.span, &supply);
        let finest = piece.depth >= robot.tolerances.stiff_depth || *events == 0;
        let attempt = trial_step(robot, state, piece.span, &supply, finest);
        let exact = piece.depth < robot.tolerances.depth && *events > 0;
        match attempt.outcome {
            StepOutcome::Steady => state.body = attempt.body,
            StepOutcome::Broken(broken) if !regrouped => {
                regrouped = true;
                let change = ActiveSetChange {
                    broken,
                    ..ActiveSetChange::default()
                };
                update_active_set(robot, state, piece.span, &supply, change);
                continue;
            }
            StepOutcome::Broken(_) => accept_at_limit(robot, state, &piece, &supply),
            StepOutcome::Event(_) if exact => bisect(robot, state, piece, 1, events),
            StepOutcome::Coarse(halvings) if exact => {
                let left = robot.tolerances.stiff_depth.saturating_sub(piece.depth);
                bisect(robot, state, piece, halvings.min(left), events);
            }
            StepOutcome::Event(event) => {
                *events = events.saturating_sub(1);
                state.body = attempt.body;
                apply_event(robot, state, piece.span, &supply, &event);
            }
            StepOutcome::Coarse(_) => state.body = attempt.body,
        }
        return;
    }
}

/// Both halves of a piece, the first of them halved again until there are `halvings`.
fn bisect<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    piece: Segment<S>,
    halvings: u32,
    events: &mut u32,
) {
    let [t_s, over_s] = piece.span;
    let half = |span: Pair<f64>| Segment {
        span,
        depth: piece.depth + 1,
        ..piece
    };
    let first = half([t_s, over_s / 2.0]);
    if halvings > 1 {
        bisect(robot, state, first, halvings - 1, events);
    } else {
        advance(robot, state, first, events);
    }
    let second = half([t_s + over_s / 2.0, over_s - over_s / 2.0]);
    advance(robot, state, second, events);
}

/// Goes on although what was just decided does not hold: the force is at the limit to rounding.
fn accept_at_limit<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    piece: &Segment<S>,
    supply: &ActuatorOutput<S>,
) {
    let loose = state.mode.loose;
    state.mode.loose = ElementSet::default();
    state.body = trial_step(robot, state, piece.span, supply, true).body;
    state.mode.loose = loose;
}

/// Changes the mode where a piece has ended at an event. Where a parameter moves the event by
/// δt, the motion before it goes on δt longer and the one after it begins δt later: both are
/// taken along a δt that is zero and carries derivatives alone.
fn apply_event<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    supply: &ActuatorOutput<S>,
    event: &Event<S>,
) {
    let shift = event.shift(span[1]);
    let end = [span[0] + span[1], span[1]];
    if S::NDERIV > 0 {
        shift_along(robot, state, supply, &event.before, shift);
    }
    if event.stopped.is_empty() && event.broken.is_empty() {
        // otherwise the acceleration, and what gears pass on with it, are not those after it
        update_gears(robot, state);
    }
    if !event.stopped.is_empty() {
        // what is left of their motion, smaller than what the piece could resolve
        let held = state.mode.held.either(event.stopped);
        let left = project_velocity(robot, state, held) - state.body.nu;
        state.body.nu += left.map(|left| S::constant(left.value()));
    }
    let Event {
        stopped, broken, ..
    } = *event;
    update_active_set(
        robot,
        state,
        end,
        supply,
        ActiveSetChange { stopped, broken },
    );
    if S::NDERIV > 0 {
        let after = acceleration_now(robot, state, end, supply);
        shift_along(robot, state, supply, &after, -shift);
    }
}

/// Moves the body along `acceleration` for an instant `shift`.
fn shift_along<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    supply: &ActuatorOutput<S>,
    acceleration: &Vector<S>,
    shift: S,
) {
    let kind = state.mode.kind;
    let torque = motor_torque(robot, kind, supply.mean);
    let body = &mut state.body;
    let [cos, sin] = heading(body.pose[2]);
    body.pose[0] += (body.nu[0] * cos - body.nu[1] * sin) * shift;
    body.pose[1] += (body.nu[0] * sin + body.nu[1] * cos) * shift;
    body.pose[2] += body.nu[2] * shift;
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
