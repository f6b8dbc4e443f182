//! One smooth step with a fixed set of held elements, and the outcome whether the set still holds.

use super::outcome::{Event, StepOutcome};
use super::state::State;
use crate::dynamics::forces::{Forces, applied_forces, forces_at};
use crate::dynamics::inertia::{
    damping_vector, inertia_matrix, is_damped, motor_torque, wheel_inertias,
};
use crate::dynamics::prescribed::{enforce_rolling, prescribed_acceleration};
use crate::integrate::events::{gear_event, patch_event};
use crate::integrate::friction_jacobian::{friction_jacobian, implicit_dynamics};
use crate::integrate::kinematics::advance_configuration;
use crate::integrate::margin::friction_margin;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::friction_elements::ElementSet;
use crate::parts::scalar::{Pair, Scalar, Vector, length_square, smaller};
use crate::parts::tolerances::{SLIP_DIRECTION_MIN, TURN_MAX};
use crate::robot::Robot;
use crate::robot::body::{Body, Gear};

/// Where a step leads.
pub(crate) struct TrialStep<S> {
    pub(crate) body: Body<S>,
    pub(crate) outcome: StepOutcome<S>,
}

/// Explicit trapezoidal step (Heun), damping implicit. Slow slip is stiff: a step too long for
/// it is refused, or, where it may not be halved any more (`finest`), taken implicitly.
pub(crate) fn trial_step<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    span: Pair<f64>,
    supply: &ActuatorOutput<S>,
    finest: bool,
) -> TrialStep<S> {
    let (from, mode) = (&state.body, &state.mode);
    let [_, over_s] = span;
    let kind = mode.kind;
    let torque = motor_torque(robot, kind, supply.mean);
    let mut at_wheel = torque;
    for (torque, gear) in at_wheel.iter_mut().zip(mode.gear) {
        if !gear.is_engaged() {
            *torque = S::constant(0.0);
        }
    }
    let forced =
        prescribed_acceleration(robot, &state.operator, &state.dynamics_key, over_s, supply);
    let damped = is_damped(robot, kind).then(|| damping_vector(robot, kind, mode.gear));
    let loss = damped.map(|damping| damping.component_mul(&from.nu));
    let applied = |nu: &Vector<S>, yaw: S| {
        let applied = applied_forces(robot, nu, yaw, span, at_wheel);
        let applied = loss.map_or(applied, |loss| applied - loss);
        let applied = forced.map_or(applied, |[_, taken]| applied - taken);
        state.load.map_or(applied, |load| applied + load)
    };
    let forced = forced.map_or(Vector::zeros(), |[forced, _]| forced);
    let first = forces_at(
        robot,
        mode,
        &state.operator,
        &from.nu,
        applied(&from.nu, from.pose[2]),
        forced[0],
    );
    let margin = friction_margin(robot, mode, &state.operator, &first);
    let broken = margin.map_or(ElementSet::default(), |margin| margin.broken);
    if !broken.is_empty() {
        return TrialStep {
            body: *from,
            outcome: StepOutcome::Broken(broken),
        };
    }
    let brake = friction_jacobian(robot, state, &first, over_s);
    if let Some((_, halvings)) = brake.filter(|_| !finest) {
        return TrialStep {
            body: *from,
            outcome: StepOutcome::Coarse(halvings),
        };
    }
    let stiff = brake.map(|(brake, _)| implicit_dynamics(robot, mode, brake, over_s));
    let operator = stiff.as_ref().unwrap_or(&state.operator);
    let start = operator.accelerate(&first.force) + forced;
    let guess = from.nu + start * S::constant(over_s);
    let yaw = from.pose[2] + (from.nu[2] + guess[2]) * (0.5 * over_s);
    let second = forces_at(
        robot,
        mode,
        operator,
        &guess,
        applied(&guess, yaw),
        forced[0],
    );
    let end = operator.accelerate(&second.force) + forced;
    let mut body = *from;
    body.nu = match &stiff {
        None => from.nu + (start + end) * S::constant(0.5 * over_s),
        Some(operator) => {
            // the two-stage Rosenbrock method of second order for any Jacobian
            let inertia = inertia_matrix(robot, wheel_inertias(robot, mode.gear));
            let own = operator.accelerate(&(inertia * start));
            let end = (end - own * S::constant(2.0)) * S::constant(0.5);
            from.nu + (start * S::constant(1.5) + end) * S::constant(over_s)
        }
    };
    enforce_rolling(robot, kind, mode.held, &mut body.nu);
    body.acceleration = end;
    body.contact = second.contact;
    body.lagged = supply.lagged;
    advance_configuration(robot, state, &mut body, over_s, supply, torque);
    let mut outcome = check_mode(robot, state, &body, &guess, [&first, &second]);
    if let StepOutcome::Event(event) = &mut outcome {
        event.before = start;
    }
    TrialStep { body, outcome }
}

/// Whether the mode of the step's start still stands at its end.
fn check_mode<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    to: &Body<S>,
    guess: &Vector<S>,
    [first, second]: [&Forces<S>; 2],
) -> StepOutcome<S> {
    let (from, mode) = (&state.body, &state.mode);
    if mode.loose.is_empty() && mode.gear == [Gear::Rigid; 2] && !robot.effects.has_floor {
        return StepOutcome::Steady;
    }
    let margin = |balance| friction_margin(robot, mode, &state.operator, balance);
    if let Some(end) = margin(second).filter(|end| !end.broken.is_empty()) {
        let start = margin(first).map_or(end.least, |start| start.least);
        let event = Event::new(start, end.least);
        return StepOutcome::Event(Event {
            broken: end.broken,
            ..event
        });
    }
    let mut outcome = StepOutcome::Steady;
    let mut stop: Option<Event<S>> = None;
    for element in mode.loose.iter().filter(|&element| mode.slides(element)) {
        let mut seen = robot.seen(element, &from.nu);
        if length_square(seen) <= SLIP_DIRECTION_MIN * SLIP_DIRECTION_MIN {
            seen = mode.direction[element as usize];
        }
        let seen = seen.map(|part| S::constant(part.value()));
        let led = mode.is_led(element);
        let ahead = |nu: &Vector<S>| {
            let [along, across] = robot.seen(element, nu);
            let across = if led { S::constant(0.0) } else { across };
            (seen[0] * along + seen[1] * across, [along, across])
        };
        // a guess that overshoots would average friction forward with friction backward
        let (end, then) = ahead(&to.nu);
        let end = smaller(end, ahead(guess).0);
        if end.value() <= 0.0 {
            let stop = stop.get_or_insert_with(|| Event::new(ahead(&from.nu).0, end));
            stop.stopped = stop.stopped.with(element);
            continue;
        }
        let cross = (seen[0] * then[1] - seen[1] * then[0]).value();
        if !led && cross * cross > TURN_MAX * length_square(seen) * length_square(then) {
            outcome = StepOutcome::Coarse(1);
        }
    }
    if let Some(stop) = stop {
        return StepOutcome::Event(stop);
    }
    if mode.gear != [Gear::Rigid; 2]
        && let Some(event) = gear_event(robot, state, to)
    {
        return StepOutcome::Event(event);
    }
    if robot.effects.has_floor
        && let Some(event) = patch_event(robot, from, to)
    {
        return StepOutcome::Event(event);
    }
    outcome
}
