//! Check of a trial step: whether its mode holds to the end, or which event ends it.

use super::floor::patch_event;
use super::friction_margin::friction_margin;
use super::gears::gear_event;
use super::outcome::{Event, StepOutcome};
use super::state::State;
use crate::dynamics::forces::Forces;
use crate::parts::scalar::{Scalar, Vector, length_square, smaller};
use crate::parts::tolerances::{SLIP_DIRECTION_MIN, TURN_MAX};
use crate::robot::Robot;
use crate::robot::body::Body;
use crate::robot::mode::Gear;

/// Whether the mode of `state` holds until `to`, which a step reached over the predicted velocity
/// `guess`, with the forces of its two stages.
pub(super) fn check_mode<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    to: &Body<S>,
    guess: &Vector<S>,
    forces: [&Forces<S>; 2],
) -> StepOutcome<S> {
    let mode = &state.mode;
    let rigid_gears = mode.gear == [Gear::Rigid; 2];
    if mode.frictional.is_empty() && rigid_gears && !robot.effects.has_floor {
        return StepOutcome::Accepted;
    }
    if let Some(event) = break_away_event(robot, state, forces) {
        return StepOutcome::Event(event);
    }
    let sliding = check_sliding(robot, state, to, guess);
    if matches!(sliding, StepOutcome::Event(_)) {
        return sliding;
    }
    if !rigid_gears && let Some(event) = gear_event(robot, state, to) {
        return StepOutcome::Event(event);
    }
    if robot.effects.has_floor
        && let Some(event) = patch_event(robot, &state.body, to)
    {
        return StepOutcome::Event(event);
    }
    sliding
}

/// Sticking constraints that exceed their friction limit at the step's end.
fn break_away_event<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    [first, second]: [&Forces<S>; 2],
) -> Option<Event<S>> {
    let margin = |forces| friction_margin(robot, &state.mode, &state.dynamics, forces);
    let end = margin(second).filter(|end| !end.exceeded.is_empty())?;
    let start = margin(first).map_or(end.smallest, |start| start.smallest);
    Some(Event {
        broken_away: end.exceeded,
        ..Event::new(start, end.smallest)
    })
}

/// Sliding constraints: an event if the slip of one reverses, which comes to rest then; too long a
/// step if the direction of one turns too far; else accepted.
fn check_sliding<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    to: &Body<S>,
    guess: &Vector<S>,
) -> StepOutcome<S> {
    let (from, mode) = (&state.body, &state.mode);
    let mut outcome = StepOutcome::Accepted;
    let mut stop: Option<Event<S>> = None;
    let sliding = mode.frictional.iter().filter(|&c| mode.slides(c));
    for constraint in sliding {
        let mut slip = robot.slip_velocity(constraint, &from.nu);
        if length_square(slip) <= SLIP_DIRECTION_MIN * SLIP_DIRECTION_MIN {
            slip = mode.direction[constraint as usize];
        }
        let slip = slip.map(|part| S::constant(part.value()));
        let longitudinal_only = mode.slides_longitudinally_only(constraint);
        // slip at another velocity, and its component along the present one
        let progress = |nu: &Vector<S>| {
            let [along, across] = robot.slip_velocity(constraint, nu);
            let across = if longitudinal_only {
                S::constant(0.0)
            } else {
                across
            };
            (slip[0] * along + slip[1] * across, [along, across])
        };
        // a prediction beyond the reversal would average friction of both signs
        let (end, end_slip) = progress(&to.nu);
        let end = smaller(end, progress(guess).0);
        if end.value() <= 0.0 {
            let stop = stop.get_or_insert_with(|| Event::new(progress(&from.nu).0, end));
            stop.stopped = stop.stopped.with(constraint);
            continue;
        }
        let cross = (slip[0] * end_slip[1] - slip[1] * end_slip[0]).value();
        let turn = cross * cross > TURN_MAX * length_square(slip) * length_square(end_slip);
        if !longitudinal_only && turn {
            outcome = StepOutcome::TooLong(1);
        }
    }
    stop.map_or(outcome, StepOutcome::Event)
}
