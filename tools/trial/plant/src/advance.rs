//! Time stepping with event location by bisection.

use crate::actuators::Commands;
use crate::backlash::{close, closing};
use crate::contact::{Contact, ContactKind, dot};
use crate::physics::Push;
use crate::plant::Plant;
use crate::state::State;

/// Times closer than this count as one (s).
const INSTANT_S: f64 = 1e-10;

impl Plant {
    /// Simulates up to `to_s` (s) and calls `show` with the states before and after each step.
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
            // A remainder due to rounding belongs to this step.
            let h = if to_s - state.t_s - h < INSTANT_S {
                to_s - state.t_s
            } else {
                h
            };
            let next = self.step_to_event(commands, state, h);
            show(state, &next);
            *state = next;
        }
    }

    /// The next time at which a force jumps: a new command, or the edge of a push (s).
    fn next_s(&self, commands: &Commands, t_s: f64) -> f64 {
        let t_s = t_s + INSTANT_S;
        let edges = |push: &Push| [push.t_s, push.t_s + Push::DURATION_S];
        let edges = self
            .physics
            .pushes
            .iter()
            .flat_map(edges)
            .filter(|edge| *edge > t_s);
        edges.fold(commands.next_s(t_s, self.physics.delay_s), f64::min)
    }

    /// One step of length `h` (s), or up to the first event in it.
    fn step_to_event(&self, commands: &Commands, state: &State, h: f64) -> State {
        let mut next = self.trial_step(commands, state, h);
        if self.crosses_event(state, &next) {
            let (mut before, mut after) = (0.0, h);
            while after - before > INSTANT_S {
                let middle = (before + after) / 2.0;
                let tried = self.trial_step(commands, state, middle);
                if self.crosses_event(state, &tried) {
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
            self.impact(&mut next);
        }
        next
    }

    /// Whether an event lies between two states: backlash closes, a wheel enters or leaves a patch, a contact
    /// changes its direction of slip, sticks or breaks away, an effect outside the vocabulary begins or ends.
    fn crosses_event(&self, state: &State, next: &State) -> bool {
        let jumps = |(at, contact): (usize, &Contact)| match contact.kind {
            // Backlash has events of its own.
            ContactKind::Gear(_) => false,
            _ if !state.stuck[at] => {
                let slips = [state, next].map(|s| contact.rows.map(|row| dot(&row, &s.velocity)));
                let [from, to] = slips;
                next.stuck[at] || from[0] * to[0] + from[1] * to[1] < 0.0
            }
            ContactKind::Wheel(i) if !next.stuck[at] => self.weakens(state, i),
            _ => false,
        };
        let outside = &self.physics.outside;
        closing(next, self.physics.gap) != [0; 2]
            || self.patches(next) != next.patch
            || self.contacts.iter().enumerate().any(jumps)
            || outside
                .iter()
                .any(|outside| outside.acts(state) != outside.acts(next))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuators::Quantity;
    use crate::physics::Physics;
    use slipstream_bus::RobotModel;

    /// The state after `over_s` (s) under a torque on both wheels.
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

    /// The paper's robot with wheel slip.
    fn slipping(hold: f64, slide: f64) -> RobotModel {
        let friction = [("friction_static", hold), ("friction_kinetic", slide)];
        RobotModel::default().with("wheel_slip", &friction)
    }

    #[test]
    fn rolling_accelerates_by_equation_8() {
        let (_, state) = driven(&RobotModel::default(), 0.05, 1.0);
        let (m, r, spin) = (1.628, 0.0365, 0.001_168);
        // Twice the force of Eq. 8 acts on the total mass.
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
    fn a_robot_held_by_friction_stands_still() {
        let slope = [("grade", 0.02), ("downhill_rad", 0.7)];
        let model = slipping(0.3, 0.25)
            .with("floor_slope", &slope)
            .with("axle_friction", &[("torque_nm", 0.01)]);
        let (_, state) = driven(&model, 0.0, 2.0);
        // Only rounding errors, which do not grow.
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
        // It rolls, turns and slides sideways.
        state.velocity = [0.6, 0.3, 4.0, 20.0, 5.0, 20.0, 5.0];
        state.stuck = [false; crate::state::CONTACTS];
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
