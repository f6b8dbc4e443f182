//! Steps strung together, ended early where something happens.

use super::body::Body;
use super::contact::{Contact, Law, Rolling, contacts, dot};
use super::drive::{Commands, Quantity};
use super::gear::{close, closing};
use super::physics::{Physics, Push};
use super::state::State;

/// Instants closer than this are one (s).
const INSTANT_S: f64 = 1e-10;

/// One robot, ready to move.
#[derive(Debug, Clone)]
pub struct Plant {
    /// Its numbers.
    pub physics: Physics,
    pub(crate) body: Body,
    /// Rolling that is held exactly, where nothing can slip.
    pub(crate) rolling: Option<Rolling>,
    pub(crate) contacts: Vec<Contact>,
    step_s: f64,
}

impl Plant {
    /// A robot under commands of this quantity, in steps of `step_s` at most.
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

    /// At rest at a pose.
    pub fn start(&self, pose: [f64; 3]) -> State {
        let mut state = State::at(pose);
        state.patch = self.patches(&state);
        state
    }

    /// What this robot is in another one's state: where that is, and as fast.
    pub fn adopt(&self, other: &State, commands: &Commands) -> State {
        let mut state = State::at(other.pose);
        state.t_s = other.t_s;
        state.wheel = other.wheel;
        state.velocity = other.velocity;
        state.lagged = other.lagged;
        if let Some(rolling) = &self.rolling {
            rolling.restore(&mut state.velocity);
        }
        // a drive without play stands where the encoder is
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

    /// Moves one part of a rolling start by `by`: x, y (m), yaw (rad), surge (m/s) or yaw rate
    /// (rad/s), the wheels with it.
    pub fn nudge(&self, state: &mut State, part: usize, by: f64) {
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
        for (i, (rim, radius)) in wheels.into_iter().zip(self.physics.radius).enumerate() {
            let speed = rim / radius;
            state.velocity[3 + i] += speed;
            state.velocity[5 + i] += speed;
        }
    }

    /// Moves on to `to_s` and shows each step: the state before and the state after.
    pub fn advance(
        &self,
        commands: &Commands,
        state: &mut State,
        to_s: f64,
        mut show: impl FnMut(&State, &State),
    ) {
        while to_s - state.t_s > INSTANT_S {
            let h = self
                .step_s
                .min(self.next_s(commands, state.t_s).min(to_s) - state.t_s);
            // a rest that rounding leaves is part of the step
            let h = if to_s - state.t_s - h < INSTANT_S {
                to_s - state.t_s
            } else {
                h
            };
            let next = self.piece(commands, state, h);
            show(state, &next);
            *state = next;
        }
    }

    /// When forces jump next.
    fn next_s(&self, commands: &Commands, t_s: f64) -> f64 {
        let t_s = t_s + INSTANT_S;
        let edges = |push: &Push| [push.t_s, push.t_s + Push::LASTS_S];
        let edges = self
            .physics
            .pushes
            .iter()
            .flat_map(edges)
            .filter(|edge| *edge > t_s);
        edges.fold(commands.next_s(t_s, self.physics.delay_s), f64::min)
    }

    /// One step of length `h`, or as far as to the first thing that happens in it.
    fn piece(&self, commands: &Commands, state: &State, h: f64) -> State {
        let mut next = self.attempt(commands, state, h);
        if self.happens(state, &next) {
            let (mut before, mut after) = (0.0, h);
            while after - before > INSTANT_S {
                let middle = (before + after) / 2.0;
                let tried = self.attempt(commands, state, middle);
                if self.happens(state, &tried) {
                    (after, next) = (middle, tried);
                } else {
                    before = middle;
                }
            }
        }
        next.patch = self.patches(&next);
        let closed = closing(&next, self.physics.gap);
        if closed != [0; 2] {
            close(&mut next, self.physics.gap, closed);
            self.strike(&mut next);
        }
        next
    }

    /// Whether a step ended beyond an edge that forces jump at.
    fn happens(&self, state: &State, next: &State) -> bool {
        let jumps = |(at, contact): (usize, &Contact)| match contact.law {
            // a gear's turning points are events of their own
            Law::Gear(_) => false,
            _ if !state.stuck[at] => {
                let slips = [state, next].map(|s| contact.rows.map(|row| dot(&row, &s.velocity)));
                let [from, to] = slips;
                next.stuck[at] || from[0] * to[0] + from[1] * to[1] < 0.0
            }
            Law::Wheel(i) if !next.stuck[at] => self
                .friction(state, i)
                .is_some_and(|[hold, slide]| hold > slide),
            _ => false,
        };
        let strange = &self.physics.strange;
        closing(next, self.physics.gap) != [0; 2]
            || self.patches(next) != next.patch
            || self.contacts.iter().enumerate().any(jumps)
            || strange
                .iter()
                .any(|strange| strange.at_work(state) != strange.at_work(next))
    }

    /// μ_s and μ_k under a wheel; `None` never slips.
    pub(crate) fn friction(&self, state: &State, wheel: usize) -> Option<[f64; 2]> {
        let patch = state.patch[wheel].map(|at| [self.physics.patches[at].friction; 2]);
        patch.or(self.physics.grip)
    }

    /// Whether a wheel that breaks away holds less than one that sticks.
    pub(crate) fn weakens(&self, state: &State, wheel: usize) -> bool {
        self.friction(state, wheel)
            .is_some_and(|[hold, slide]| hold > slide)
    }

    /// Which patch each wheel's contact is in.
    fn patches(&self, state: &State) -> [Option<usize>; 2] {
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

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_bus::RobotModel;

    /// After `over_s` under a torque on both wheels.
    fn driven(model: &RobotModel, torque_nm: f64, over_s: f64) -> (Plant, State) {
        let plant = Plant::new(Physics::new(model).unwrap(), Quantity::Torque, 1e-4);
        let rows = vec![(0.0, [torque_nm; 2])];
        let commands = Commands {
            quantity: Quantity::Torque,
            rows,
        };
        let mut state = plant.start([0.0; 3]);
        plant.advance(&commands, &mut state, over_s, |_, _| {});
        (plant, state)
    }

    fn slipping(hold: f64, slide: f64) -> RobotModel {
        let friction = [("friction_static", hold), ("friction_kinetic", slide)];
        RobotModel::default().with("wheel_slip", &friction)
    }

    #[test]
    fn rolling_accelerates_as_equation_8_says() {
        let (_, state) = driven(&RobotModel::default(), 0.05, 1.0);
        let (m, r, spin) = (1.628, 0.0365, 0.001_168);
        // twice the force of Eq. 8 on the whole mass
        let expected = 2.0 * 0.05 * r / (m * r * r + 2.0 * spin);
        assert!(
            (state.velocity[0] - expected).abs() < 1e-11,
            "{:?}",
            state.velocity
        );
    }

    #[test]
    fn sliding_accelerates_by_kinetic_friction() {
        let (plant, state) = driven(&slipping(0.241, 0.2), 0.2, 0.5);
        let [right, left, _] = plant.body.normal(0.0, 0.0);
        let expected = 0.2 * (right + left) / 1.628 * 0.5;
        assert!(
            (state.velocity[0] - expected).abs() < 1e-5,
            "{:?}",
            state.velocity
        );
        assert!(state.slip_m_s[0] > 0.1);
    }

    #[test]
    fn what_friction_holds_stands_still() {
        let slope = [("grade", 0.02), ("downhill_rad", 0.7)];
        let model = slipping(0.3, 0.25)
            .with("floor_slope", &slope)
            .with("axle_friction", &[("torque_nm", 0.01)]);
        let (_, state) = driven(&model, 0.0, 2.0);
        // rounding, and nothing that grows
        assert!(
            state.pose.iter().all(|value| value.abs() < 1e-12),
            "{:?}",
            state.pose
        );
    }

    #[test]
    fn a_coasting_robot_keeps_its_energy_unless_it_slides() {
        let model = slipping(0.2, 0.2);
        let plant = Plant::new(Physics::new(&model).unwrap(), Quantity::Torque, 1e-4);
        let commands = Commands {
            quantity: Quantity::Torque,
            rows: Vec::new(),
        };
        let mut state = plant.start([0.0; 3]);
        // rolls, turns and slides sideways
        state.velocity = [0.6, 0.3, 4.0, 20.0, 5.0, 20.0, 5.0];
        state.stuck = [false; super::super::state::CONTACTS];
        let energy = |state: &State| {
            let [u, v, w, right, left, ..] = state.velocity;
            let [sx, sy] = plant.body.moment;
            let inertia =
                0.009_753 + 2.0 * 0.000_584 + 0.128 * (0.105f64.powi(2) + 0.055f64.powi(2));
            plant.body.mass * (u * u + v * v) / 2.0
                + w * (sx * v - sy * u)
                + inertia * w * w / 2.0
                + 0.001_168 * (right * right + left * left) / 2.0
        };
        let mut last = energy(&state);
        for k in 1..200 {
            plant.advance(&commands, &mut state, f64::from(k) * 0.005, |_, _| {});
            let now = energy(&state);
            assert!(now <= last + 1e-9, "{now} after {last}");
            last = now;
        }
        assert_eq!(state.slip_m_s.map(|slip| slip < 1e-9), [true; 2]);
    }
}
