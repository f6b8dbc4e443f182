//! Event-driven time stepping: smooth segments between events, which are located by bisection.

use super::active_set::{ActiveSetChange, update_active_set};
use super::fast::draft;
use super::outcome::StepOutcome;
use super::prepare::prepare_dynamics;
use super::saltation::apply_event;
use super::state::State;
use super::trial_step::trial_step;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::{Command, CommandKind};
use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::GIVEN_SLIP_MIN;
use crate::robot::Robot;

/// Part of a step under one command, without a change of a delayed command in its interior.
#[derive(Debug, Clone, Copy)]
struct Segment<S> {
    /// Start and length (s).
    span: Pair<f64>,
    /// Command at the wheels.
    command: Pair<S>,
    /// Number of bisections that led to it.
    depth: u32,
}

impl<S: Scalar> Robot<S> {
    /// Advances `state` from time `t_s` by `dt_s` (s) under `command`, held throughout.
    ///
    /// Second order in `dt_s`. Changes between sticking and sliding, and all other events, are
    /// located inside the step. Allocates nothing, unless a delay line holds more than 1024
    /// commands.
    pub fn step(&self, state: &mut State<S>, t_s: f64, dt_s: f64, command: &Command<S>) {
        let (kind, command) = self.at_wheels(command);
        if kind == CommandKind::Torque
            && let Some(fast_path) = &state.fast_path
            && fast_path.step(
                self,
                state.external_force.as_ref(),
                &mut state.body,
                dt_s,
                command,
            )
        {
            return;
        }
        if kind != state.mode.kind {
            state.mode.kind = kind;
            let none = ActiveSetChange::default();
            update_active_set(self, state, [t_s, dt_s], &ActuatorOutput::zero(), none);
        }
        self.actuator.store(&mut state.history, t_s, command);
        let mut from = t_s;
        let mut events = self.tolerances.events;
        loop {
            let rest = t_s + dt_s - from;
            let change = self.actuator.next_change(&state.history, [from, rest]);
            let segment = Segment {
                span: [from, change.map_or(rest, |at| at - from)],
                command,
                depth: 0,
            };
            if kind == CommandKind::Speed {
                jump_to_speed(self, state, &segment);
            }
            advance(self, state, segment, &mut events);
            match change {
                Some(at) => from = at,
                None => return,
            }
        }
    }
}

/// Advances by one segment: accepts the trial step if the mode holds throughout, else bisects until
/// the event lies at the end of a segment and applies it there. `events` counts down the events
/// that may still be located in this step.
fn advance<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    segment: Segment<S>,
    events: &mut u32,
) {
    let span = segment.span;
    let tolerances = &robot.tolerances;
    let mut updated = false;
    loop {
        let actuation = actuation(robot, state, &segment);
        if draft::step(robot, state, span, &actuation) {
            return;
        }
        prepare_dynamics(robot, state, span, &actuation);
        let implicit = segment.depth >= tolerances.stiff_bisections || *events == 0;
        let trial = trial_step(robot, state, span, &actuation, implicit);
        let may_bisect = segment.depth < tolerances.bisections && *events > 0;
        match trial.outcome {
            StepOutcome::Accepted => state.body = trial.body,
            StepOutcome::LimitExceeded(broken_away) if !updated => {
                updated = true;
                let change = ActiveSetChange {
                    broken_away,
                    ..ActiveSetChange::default()
                };
                update_active_set(robot, state, span, &actuation, change);
                continue;
            }
            StepOutcome::LimitExceeded(_) => step_at_limit(robot, state, span, &actuation),
            StepOutcome::Event(_) if may_bisect => bisect(robot, state, segment, 1, events),
            StepOutcome::TooLong(bisections) if may_bisect => {
                let left = tolerances.stiff_bisections.saturating_sub(segment.depth);
                bisect(robot, state, segment, bisections.min(left), events);
            }
            StepOutcome::Event(event) => {
                *events = events.saturating_sub(1);
                state.body = trial.body;
                apply_event(robot, state, span, &actuation, &event);
            }
            StepOutcome::TooLong(_) => state.body = trial.body,
        }
        return;
    }
}

/// Advances by both halves of a segment, the first of them bisected again until there are
/// `bisections` in all.
fn bisect<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    segment: Segment<S>,
    bisections: u32,
    events: &mut u32,
) {
    let [t_s, over_s] = segment.span;
    let half = |span: Pair<f64>| Segment {
        span,
        depth: segment.depth + 1,
        ..segment
    };
    let first = half([t_s, over_s / 2.0]);
    if bisections > 1 {
        bisect(robot, state, first, bisections - 1, events);
    } else {
        advance(robot, state, first, events);
    }
    let second = half([t_s + over_s / 2.0, over_s - over_s / 2.0]);
    advance(robot, state, second, events);
}

/// Steps with the present active set although its margins are exceeded right after an update: the
/// forces are at their limit to rounding.
fn step_at_limit<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
) {
    let frictional = state.mode.frictional;
    state.mode.frictional = ConstraintSet::default();
    state.body = trial_step(robot, state, span, actuation, true).body;
    state.mode.frictional = frictional;
}

/// Sets the wheel speeds to the output of the actuators for a speed command. Wheels with friction
/// slip by the jump; with wheels that cannot slide the whole robot jumps.
fn jump_to_speed<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, segment: &Segment<S>) {
    let actuation = actuation(robot, state, segment);
    prepare_dynamics(robot, state, segment.span, &actuation);
    let mut slips = false;
    let mut moved = Vector::from([S::constant(0.0); 5]);
    for (i, axle) in FrictionConstraint::AXLES.into_iter().enumerate() {
        if !state.mode.gear[i].is_engaged() {
            continue;
        }
        let change = actuation.start[i] - state.body.nu[3 + i];
        state.body.nu[3 + i] = actuation.start[i];
        let rolls = state.mode.wheel_friction[i].is_none();
        if rolls {
            moved += state.dynamics.response(axle.rows()[0], change);
            moved[3 + i] -= change;
        }
        slips |= !rolls && change.value().abs() > GIVEN_SLIP_MIN;
    }
    state.body.nu += moved;
    if slips {
        let none = ActiveSetChange::default();
        update_active_set(robot, state, segment.span, &actuation, none);
    }
}

/// Output of the actuators over a segment.
fn actuation<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    segment: &Segment<S>,
) -> ActuatorOutput<S> {
    let (kind, lagged) = (state.mode.kind, state.body.lagged);
    robot
        .actuator
        .output(kind, segment.command, &state.history, lagged, segment.span)
}
