//! One robot, assembled: masses, dry contacts, and the translation between states.

use crate::actuators::{Commands, Quantity};
use crate::body::Body;
use crate::contact::{Contact, Rolling, contacts, dot};
use crate::physics::Physics;
use crate::state::State;

/// One robot, ready to be simulated.
#[derive(Debug, Clone)]
pub struct Plant {
    /// Its parameters.
    pub physics: Physics,
    pub(crate) body: Body,
    /// The rolling constraint, if the robot cannot slip.
    pub(crate) rolling: Option<Rolling>,
    pub(crate) contacts: Vec<Contact>,
    /// Longest step (s).
    pub(crate) step_s: f64,
}

impl Plant {
    /// A robot under commands of this quantity, with steps of at most `step_s` (s).
    pub fn new(physics: Physics, quantity: Quantity, step_s: f64) -> Self {
        let body = Body::new(&physics, quantity == Quantity::Speed);
        let rolling = Rolling::new(&physics, &body);
        let contacts = contacts(&physics, &body, rolling.as_ref());
        Self {
            physics,
            body,
            rolling,
            contacts,
            step_s,
        }
    }

    /// The state at rest at a pose: x, y (m) and yaw (rad) of the centre of mass.
    pub fn start(&self, pose: [f64; 3]) -> State {
        let mut state = State::at(pose);
        state.patch = self.patches(&state);
        state
    }

    /// The state of this robot at the pose and velocity of another one, `other`.
    pub fn adopt(&self, other: &State, commands: &Commands) -> State {
        let mut state = State::at(other.pose);
        state.t_s = other.t_s;
        state.wheel = other.wheel;
        state.velocity = other.velocity;
        state.lagged = other.lagged;
        if let Some(rolling) = &self.rolling {
            rolling.restore(&mut state.velocity);
        }
        // Without backlash the wheel is where the encoder is.
        let offset = [0, 1].map(|i| other.motor[i] - other.wheel[i]);
        state.motor = other.motor;
        if self.physics.gap <= 0.0 {
            state.wheel = [0, 1].map(|i| other.wheel[i] + offset[i]);
        }
        if self.physics.lag_s > 0.0 && other.lagged == [0.0; 2] {
            state.lagged = commands.drive(&self.physics, &state, 1e-9).lagged;
        }
        for (at, contact) in self.contacts.iter().enumerate() {
            let slip = contact.rows.map(|row| dot(&row, &state.velocity));
            state.stuck[at] = slip[0].hypot(slip[1]) < 1e-9;
        }
        state.patch = self.patches(&state);
        state
    }

    /// Changes one component of a rolling state by `by`, the wheels with it; `part` is 0 for x (m), 1 for y
    /// (m), 2 for yaw (rad), 3 for surge (m/s) and 4 for yaw rate (rad/s).
    pub fn perturb(&self, state: &mut State, part: usize, by: f64) {
        let (b, d) = (self.physics.half_track, self.physics.to_axle);
        let wheels = match part {
            0..3 => {
                state.pose[part] += by;
                return;
            }
            3 => [by, by],
            _ => [by * b, -by * b],
        };
        let body = if part == 3 {
            [by, 0.0, 0.0]
        } else {
            [0.0, d * by, by]
        };
        for (velocity, change) in state.velocity.iter_mut().zip(body) {
            *velocity += change;
        }
        for (i, (rim, rolls)) in wheels.into_iter().zip(self.physics.rolls()).enumerate() {
            let speed = rim / rolls;
            state.velocity[3 + i] += speed;
            state.velocity[5 + i] += speed;
        }
    }

    /// μ_s and μ_k under a wheel; `None` if it never slips.
    pub(crate) fn friction(&self, state: &State, wheel: usize) -> Option<[f64; 2]> {
        let patch = state.patch[wheel].map(|at| [self.physics.patches[at].friction; 2]);
        patch.or(self.physics.friction)
    }

    /// Whether the kinetic friction under a wheel is lower than the static one.
    pub(crate) fn weakens(&self, state: &State, wheel: usize) -> bool {
        self.friction(state, wheel)
            .is_some_and(|[mu_static, mu_kinetic]| mu_static > mu_kinetic)
    }

    /// The friction patch that each wheel's contact lies in.
    pub(crate) fn patches(&self, state: &State) -> [Option<usize>; 2] {
        if self.physics.patches.is_empty() {
            return [None; 2];
        }
        let (sin, cos) = state.pose[2].sin_cos();
        let (b, d) = (self.physics.half_track, self.physics.to_axle);
        [-b, b].map(|y| {
            let contact = [
                state.pose[0] - d * cos - y * sin,
                state.pose[1] - d * sin + y * cos,
            ];
            self.physics.patches.iter().position(|patch| {
                let away = (contact[0] - patch.centre[0]).hypot(contact[1] - patch.centre[1]);
                away < patch.radius
            })
        })
    }
}
