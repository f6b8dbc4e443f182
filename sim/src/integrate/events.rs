//! Where a mode ends for other reasons than friction: the floor changes, gears meet or part.

use super::outcome::Event;
use super::state::State;
use crate::dynamics::inertia::{constrained_dynamics, motor_damping, motor_torque};
use crate::parts::command::{Command, CommandKind};
use crate::parts::friction_elements::ElementSet;
use crate::parts::parameters::Friction;
use crate::parts::scalar::{Pair, Scalar, heading};
use crate::parts::tolerances::MOTOR_SHARE;
use crate::robot::Robot;
use crate::robot::body::{Body, DynamicsKey, Gear, Mode};

impl<S: Scalar> Robot<S> {
    /// How each motor pushes its wheel under a command that has acted since long ago, at these speeds of
    /// the wheels (rad/s): a torque (N m), less what it loses with speed. Where wheels turn as they are
    /// told it is the speed (rad/s), because something resists it.
    pub fn motor_efforts(&self, command: &Command<S>, wheel_speed: Pair<S>) -> Pair<S> {
        let (kind, supply) = command.at_wheels(self.nominal);
        motor_effort(self, kind, supply, wheel_speed)
    }
}

/// Where the driven wheels touch the floor, right and left (m, world frame).
fn contact_points<S: Scalar>(robot: &Robot<S>, pose: [S; 3]) -> [Pair<S>; 2] {
    let [cos, sin] = heading(pose[2]);
    let back = robot.com_to_axle;
    [-robot.half_track, robot.half_track].map(|left| {
        [
            pose[0] - back * cos - left * sin,
            pose[1] - back * sin + left * cos,
        ]
    })
}

/// Friction under each driven wheel. Of patches that overlap, the last one listed counts.
pub(crate) fn friction_at<S: Scalar>(robot: &Robot<S>, pose: [S; 3]) -> Pair<Option<Friction<S>>> {
    if !robot.effects.has_floor {
        return [robot.grip; 2];
    }
    contact_points(robot, pose).map(|contact| {
        let mut grip = robot.grip;
        robot.effects.floors(contact, |inside, own| {
            if inside.value() > 0.0 {
                grip = Some(own);
            }
        });
        grip
    })
}

/// A wheel entering or leaving a patch between two bodies.
pub(crate) fn patch_event<S: Scalar>(
    robot: &Robot<S>,
    from: &Body<S>,
    to: &Body<S>,
) -> Option<Event<S>> {
    let (before, after) = (
        contact_points(robot, from.pose),
        contact_points(robot, to.pose),
    );
    let mut event = None;
    for (before, after) in before.into_iter().zip(after) {
        let mut patch = 0;
        robot.effects.floors(before, |inside, _| {
            let mut at = 0;
            robot.effects.floors(after, |then, _| {
                if at == patch && (inside.value() > 0.0) != (then.value() > 0.0) {
                    event = Some(Event::new(inside, then));
                }
                at += 1;
            });
            patch += 1;
        });
    }
    event
}

/// A gear that closes, or one whose motor no longer presses on its wheel.
pub(crate) fn gear_event<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    to: &Body<S>,
) -> Option<Event<S>> {
    (0..2).find_map(|i| {
        let margin = |body: &Body<S>| gear_margin(robot, state.mode.gear[i], body, i, state);
        let end = margin(to)?;
        (end.value() < 0.0).then(|| Event::new(margin(&state.body).unwrap_or(end), end))
    })
}

/// How far a gear is from changing its state: play left (rad), or torque passed on (N m).
fn gear_margin<S: Scalar>(
    robot: &Robot<S>,
    gear: Gear,
    body: &Body<S>,
    i: usize,
    state: &State<S>,
) -> Option<S> {
    let half = robot.drive.gap_rad? * 0.5;
    match gear {
        Gear::Rigid => None,
        Gear::Free => {
            let apart = body.motor_angle[i] - body.angle[i];
            let closing = (body.motor_speed[i] - body.nu[3 + i]) * apart;
            let left = half - apart.abs();
            // parting again from a stop that was just left is no contact
            (closing.value() > 0.0 || left.value() > 0.0).then_some(left)
        }
        Gear::Forward => Some(transmitted_torque(robot, body, i, state)),
        Gear::Backward => Some(-transmitted_torque(robot, body, i, state)),
    }
}

/// Torque that the motor passes on to its wheel.
fn transmitted_torque<S: Scalar>(
    robot: &Robot<S>,
    body: &Body<S>,
    i: usize,
    state: &State<S>,
) -> S {
    let inertia = robot.wheel_inertia * MOTOR_SHARE;
    let motor = if state.mode.kind == CommandKind::Speed {
        // the motor holds the wheel's speed: what it passes on is what the wheel takes
        return body.acceleration[3 + i] * robot.wheel_inertia * (1.0 - MOTOR_SHARE)
            + robot.radius[i] * body.contact.along_n[i];
    } else {
        body.torque[i]
    };
    motor - inertia * body.acceleration[3 + i]
}

/// The same, of what reaches the motors.
pub(crate) fn motor_effort<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    supply: Pair<S>,
    wheel_speed: Pair<S>,
) -> Pair<S> {
    if kind == CommandKind::Speed {
        return supply;
    }
    let torque = motor_torque(robot, kind, supply);
    let loss = motor_damping(robot, kind);
    [0, 1].map(|i| torque[i] - loss * wheel_speed[i])
}

/// Engages gears that have closed and releases those that no longer press.
pub(crate) fn update_gears<S: Scalar>(robot: &Robot<S>, state: &mut State<S>) {
    for i in 0..2 {
        let gear = state.mode.gear[i];
        let margin = gear_margin(robot, gear, &state.body, i, state);
        if margin.is_none_or(|margin| margin.value() >= 0.0) {
            continue;
        }
        if gear.is_engaged() {
            state.mode.gear[i] = Gear::Free;
            continue;
        }
        let ahead = state.body.motor_angle[i].value() > state.body.angle[i].value();
        state.mode.gear[i] = if ahead { Gear::Forward } else { Gear::Backward };
        gear_impact(robot, state, i);
    }
}

/// Motor and wheel meet without rebound. Friction has no time to act: a wheel that can slip does,
/// and what rubs at rest lets go. A wheel that cannot slip takes the body along.
fn gear_impact<S: Scalar>(robot: &Robot<S>, state: &mut State<S>, i: usize) {
    let Mode {
        loose,
        mut gear,
        kind,
        ..
    } = state.mode;
    gear[i] = Gear::Free;
    let operator = constrained_dynamics(
        robot,
        &DynamicsKey {
            held: ElementSet::WHEELS.without_all(loose),
            gear,
            kind,
            over_s: 0.0,
        },
    );
    let body = &mut state.body;
    let motor = robot.wheel_inertia * MOTOR_SHARE;
    let jump = body.motor_speed[i] - body.nu[3 + i];
    if state.mode.grip[i].is_some() {
        let share = if state.mode.kind == CommandKind::Speed {
            1.0
        } else {
            MOTOR_SHARE
        };
        body.nu[3 + i] += jump * share;
    } else {
        let mobility = operator.acceleration[(3 + i, 3 + i)];
        let impulse = if state.mode.kind == CommandKind::Speed {
            jump / mobility
        } else {
            jump / (mobility + motor.recip())
        };
        body.nu += operator.acceleration.column(3 + i) * impulse;
    }
    body.motor_speed[i] = body.nu[3 + i];
}
