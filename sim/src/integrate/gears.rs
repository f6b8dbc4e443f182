//! Backlash: a dead zone between motor and wheel with perfectly inelastic contact, and the events
//! of closing and opening it.

use super::outcome::Event;
use super::state::State;
use crate::dynamics::inertia::constrained_dynamics;
use crate::dynamics::motors::{MOTOR_SHARE, motor_effort};
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::ConstraintSet;
use crate::parts::scalar::{Pair, Scalar};
use crate::robot::Robot;
use crate::robot::body::Body;
use crate::robot::mode::{Gear, Mode};

/// A gear that closes, or one that opens because its motor no longer presses on its wheel.
pub(super) fn gear_event<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    to: &Body<S>,
) -> Option<Event<S>> {
    (0..2).find_map(|i| {
        let margin = |body: &Body<S>| gear_margin(robot, &state.mode, body, i);
        let end = margin(to)?;
        (end.value() < 0.0).then(|| Event::new(margin(&state.body).unwrap_or(end), end))
    })
}

/// Margin of gear `i` to a change: the gap that is left (rad), or the torque it transmits (N m).
fn gear_margin<S: Scalar>(robot: &Robot<S>, mode: &Mode<S>, body: &Body<S>, i: usize) -> Option<S> {
    let half = robot.actuator.gap_rad? * 0.5;
    match mode.gear[i] {
        Gear::Rigid => None,
        Gear::Free => {
            let apart = body.motor_angle[i] - body.angle[i];
            let closing = (body.motor_speed[i] - body.nu[3 + i]) * apart;
            let left = half - apart.abs();
            // a gear that has just opened and moves apart is not in contact
            (closing.value() > 0.0 || left.value() > 0.0).then_some(left)
        }
        Gear::Forward => Some(transmitted_torque(robot, mode.kind, body, i)),
        Gear::Backward => Some(-transmitted_torque(robot, mode.kind, body, i)),
    }
}

/// Torque that motor `i` transmits to its wheel (N m).
fn transmitted_torque<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    body: &Body<S>,
    i: usize,
) -> S {
    if kind == CommandKind::Speed {
        // the wheel's speed is prescribed: the motor transmits what the wheel needs
        return body.acceleration[3 + i] * robot.wheel_inertia * (1.0 - MOTOR_SHARE)
            + robot.radius[i] / robot.travel[i] * body.contact.longitudinal_n[i];
    }
    let inertia = robot.wheel_inertia * MOTOR_SHARE;
    body.torque[i] - inertia * body.acceleration[3 + i]
}

/// Closes the gears whose gap is used up and opens those that transmit nothing.
pub(super) fn update_gears<S: Scalar>(robot: &Robot<S>, state: &mut State<S>) {
    for i in 0..2 {
        let margin = gear_margin(robot, &state.mode, &state.body, i);
        if margin.is_none_or(|margin| margin.value() >= 0.0) {
            continue;
        }
        if state.mode.gear[i].is_engaged() {
            state.mode.gear[i] = Gear::Free;
            continue;
        }
        let ahead = state.body.motor_angle[i].value() > state.body.angle[i].value();
        state.mode.gear[i] = if ahead { Gear::Forward } else { Gear::Backward };
        impact(robot, state, i);
    }
}

/// Perfectly inelastic impact of motor `i` on its wheel. Friction forces are finite and transmit no
/// impulse: a wheel that can slide does, and dry friction at rest gives way. A wheel that cannot
/// slide takes the body along.
fn impact<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, i: usize) {
    let Mode {
        frictional, kind, ..
    } = state.mode;
    let mut key = state
        .mode
        .dynamics_key(ConstraintSet::WHEELS.difference(frictional), 0.0);
    key.gear[i] = Gear::Free;
    let dynamics = constrained_dynamics(robot, &key);
    let body = &mut state.body;
    let motor = robot.wheel_inertia * MOTOR_SHARE;
    let jump = body.motor_speed[i] - body.nu[3 + i];
    let prescribed = kind == CommandKind::Speed;
    if state.mode.wheel_friction[i].is_some() {
        let share = if prescribed { 1.0 } else { MOTOR_SHARE };
        body.nu[3 + i] += jump * share;
    } else {
        let mobility = dynamics.acceleration[(3 + i, 3 + i)];
        let impulse = if prescribed {
            jump / mobility
        } else {
            jump / (mobility + (motor * robot.travel[i]).recip())
        };
        body.nu += dynamics.acceleration.column(3 + i) * impulse;
    }
    body.motor_speed[i] = body.nu[3 + i];
}

/// Closes the gears in the direction in which their motors press, for `actuation` that has acted
/// since long before.
pub(super) fn close_gears<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    kind: CommandKind,
    actuation: Pair<S>,
) {
    let Some(gap_rad) = robot.actuator.gap_rad else {
        return;
    };
    let wheel_speed = [state.body.nu[3], state.body.nu[4]];
    let effort = motor_effort(robot, kind, actuation, wheel_speed);
    for (i, effort) in effort.into_iter().enumerate() {
        let (side, sign) = match effort.value() {
            v if v > 0.0 => (Gear::Forward, 0.5),
            v if v < 0.0 => (Gear::Backward, -0.5),
            _ => continue,
        };
        state.mode.gear[i] = side;
        state.body.motor_angle[i] = state.body.angle[i] + gap_rad * sign;
        state.body.motor_speed[i] = state.body.nu[3 + i];
    }
}
