//! One step: smooth forces at its midpoint, dry friction as impulses over it.

use crate::actuators::Commands;
use crate::contact::{ContactKind, dot};
use crate::contact_solver::{CONVERGED, ContactImpulses};
use crate::law::Gives;
use crate::plant::Plant;
use crate::state::{CONTACTS, State, Velocity};

/// Largest number of iterations of the midpoint velocity.
const MIDPOINT_ITERATIONS: usize = 8;

impl Plant {
    /// The state `h` (s) later, if no event ends the step before.
    pub(crate) fn trial_step(&self, commands: &Commands, state: &State, h: f64) -> State {
        let drive = commands.drive(&self.physics, state, h);
        let speed = drive.speed.map(|[begin, _]| begin);
        let begin = self.prescribe(state.velocity, speed, state.contact_disturbance);
        let motor = if self.physics.gap > 0.0 { 5 } else { 3 };
        let loss = commands.loss(&self.physics);
        let mut impulses = ContactImpulses {
            impulse: state.force.map(|force| force.map(|f| f * h)),
            stuck: [true; CONTACTS],
            kinetic: state.stuck.map(|stuck| !stuck),
        };
        let mut end = begin;
        for _ in 0..MIDPOINT_ITERATIONS {
            let middle: Velocity = std::array::from_fn(|i| (begin[i] + end[i]) / 2.0);
            let mut force = self.smooth_forces(state, &middle, h);
            for i in 0..2 {
                force[motor + i] += drive.torque[i] - loss * middle[motor + i];
            }
            let mut free = begin;
            for (row, value) in self.body.inverse.iter().zip(&mut free) {
                *value += h * dot(row, &force);
            }
            if let Some([_, last]) = drive.speed {
                free[motor..motor + 2].copy_from_slice(&last);
            }
            if let Some(rolling) = &self.rolling {
                rolling.restore_to(&mut free, state.contact_disturbance);
            }
            let next = self.solve_contacts(state, &begin, free, h, &mut impulses);
            let change = largest(&next, &end);
            end = next;
            if change < CONVERGED {
                break;
            }
        }
        self.next_state(state, &begin, &end, h, drive.lagged, &impulses)
    }

    /// Changes the velocities by the impact of gears that have just closed.
    pub(crate) fn impact(&self, state: &mut State) {
        let mut impulses = ContactImpulses {
            impulse: [[0.0; 2]; CONTACTS],
            stuck: [true; CONTACTS],
            kinetic: state.stuck.map(|stuck| !stuck),
        };
        let velocity = state.velocity;
        state.velocity = self.solve_contacts(state, &velocity, velocity, 0.0, &mut impulses);
    }

    /// Sets prescribed wheel speeds, and the body velocities that follow if the robot rolls.
    fn prescribe(
        &self,
        mut velocity: Velocity,
        speed: Option<[f64; 2]>,
        contact_disturbance: [f64; 2],
    ) -> Velocity {
        if let Some(speed) = speed {
            let motor = if self.physics.gap > 0.0 { 5 } else { 3 };
            velocity[motor..motor + 2].copy_from_slice(&speed);
            if let Some(rolling) = &self.rolling {
                rolling.restore_to(&mut velocity, contact_disturbance);
            }
        }
        velocity
    }

    /// The state after a step from `begin` to `end`.
    fn next_state(
        &self,
        state: &State,
        begin: &Velocity,
        end: &Velocity,
        h: f64,
        lagged: [f64; 2],
        impulses: &ContactImpulses,
    ) -> State {
        let middle: Velocity = std::array::from_fn(|i| (begin[i] + end[i]) / 2.0);
        let [u, v, w, ..] = middle;
        let (sin, cos) = (state.pose[2] + w * h / 2.0).sin_cos();
        let mut next = State {
            t_s: state.t_s + h,
            velocity: *end,
            lagged,
            acceleration: [
                (end[0] - begin[0]) / h - v * w,
                (end[1] - begin[1]) / h + u * w,
            ],
            ..*state
        };
        if self.is_carried() {
            self.carry(state, [begin, &middle, end], h, &mut next);
        } else {
            next.pose[0] += h * (u * cos - v * sin);
            next.pose[1] += h * (u * sin + v * cos);
            next.pose[2] += h * w;
        }
        for i in 0..2 {
            next.wheel[i] += h * middle[3 + i];
            if self.physics.gap > 0.0 {
                next.motor[i] += h * middle[5 + i];
            } else {
                next.motor[i] = next.wheel[i];
                next.velocity[5 + i] = end[3 + i];
            }
        }
        for (at, contact) in self.contacts.iter().enumerate() {
            next.force[at] = impulses.impulse[at].map(|impulse| impulse / h);
            next.stuck[at] = impulses.stuck[at];
            match contact.kind {
                ContactKind::Wheel(i) => {
                    next.slip_m_s[i] = dot(&contact.rows[0], end).hypot(dot(&contact.rows[1], end));
                }
                ContactKind::Gear(i) if impulses.impulse[at][0] == 0.0 => next.gear[i] = 0,
                _ => {}
            }
        }
        let moves = end[..5].iter().any(|value| value.abs() > 1e-9);
        for outside in &self.physics.outside {
            next.settled = outside.settled(state.settled, moves, h);
        }
        next
    }
}

impl Plant {
    /// Whether laws of motion add to the motion of the wheels.
    fn is_carried(&self) -> bool {
        let moves = |gives| matches!(gives, Gives::Speed | Gives::TurnRate);
        self.physics.laws.iter().any(|law| moves(law.gives))
    }

    /// Velocity that laws of motion add to that of the wheels, [m/s, m/s, rad/s].
    fn carried(&self, t_s: f64, pose: [f64; 3], wheels: &Velocity) -> [f64; 3] {
        let (mut speed, mut turn) = (0.0, 0.0);
        for law in &self.physics.laws {
            let given = law.at(t_s, pose, [wheels[0], wheels[2]]);
            match law.gives {
                Gives::Speed => speed += given,
                Gives::TurnRate => turn += given,
                Gives::Force | Gives::Moment => {}
            }
        }
        // The middle of the axle does not move sideways.
        [speed, turn * self.physics.to_axle, turn]
    }

    /// Moves `next` from `state` by the wheels' velocities at begin, middle and end, and by what laws of
    /// motion add to them: implicit midpoint rule.
    fn carry(&self, state: &State, [begin, middle, end]: [&Velocity; 3], h: f64, next: &mut State) {
        let t_s = state.t_s;
        let mut added = state.carried;
        let mut moved = [0.0; 3];
        for _ in 0..MIDPOINT_ITERATIONS {
            let [u, v, w] = [0, 1, 2].map(|i| middle[i] + added[i]);
            let (sin, cos) = (state.pose[2] + w * h / 2.0).sin_cos();
            moved = [u * cos - v * sin, u * sin + v * cos, w];
            let there = [0, 1, 2].map(|i| state.pose[i] + moved[i] * h / 2.0);
            added = self.carried(t_s + h / 2.0, there, middle);
        }
        for (value, rate) in next.pose.iter_mut().zip(moved) {
            *value += h * rate;
        }
        let from = self.carried(t_s, state.pose, begin);
        let to = self.carried(t_s + h, next.pose, end);
        next.carried = to;
        let [u, v, w] = [0, 1, 2].map(|i| middle[i] + (from[i] + to[i]) / 2.0);
        next.acceleration = [
            (end[0] - begin[0] + to[0] - from[0]) / h - v * w,
            (end[1] - begin[1] + to[1] - from[1]) / h + u * w,
        ];
    }
}

/// The largest difference of two velocities (m/s, rad/s).
fn largest(one: &Velocity, other: &Velocity) -> f64 {
    one.iter()
        .zip(other)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}
