//! From what the actuators are told to what they do: delay, dead band, saturation, lag, gain, sag.

use super::physics::Physics;
use super::state::State;

/// What a command sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Torque at each wheel (N m).
    Torque,
    /// Voltage at each motor (V).
    Voltage,
    /// Speed of each wheel (rad/s).
    Speed,
}

/// The commands of one robot over time, [right, left].
#[derive(Debug, Clone, PartialEq)]
pub struct Commands {
    /// What they set.
    pub quantity: Quantity,
    /// Time (s) and value; one holds until the next.
    pub rows: Vec<(f64, [f64; 2])>,
}

/// What the drive does over one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drive {
    /// Mean torque before any loss with speed (N m).
    pub(crate) torque: [f64; 2],
    /// Speeds that are prescribed at the step's begin and end (rad/s).
    pub(crate) speed: Option<[[f64; 2]; 2]>,
    /// The command behind its lag, at the end.
    pub(crate) lagged: [f64; 2],
}

impl Commands {
    /// The wheel speeds of a twist (m/s, rad/s), by the radius and half track believed in.
    pub fn wheel_speeds([v, w]: [f64; 2], [radius, half_track]: [f64; 2]) -> [f64; 2] {
        [(v + half_track * w) / radius, (v - half_track * w) / radius]
    }

    /// The first instant after `t_s` at which another command takes hold.
    pub(crate) fn next_s(&self, t_s: f64, delay_s: f64) -> f64 {
        let next = self
            .rows
            .partition_point(|(row_s, _)| row_s + delay_s <= t_s);
        self.rows
            .get(next)
            .map_or(f64::INFINITY, |(row_s, _)| row_s + delay_s)
    }

    fn held(&self, t_s: f64, delay_s: f64) -> [f64; 2] {
        let next = self
            .rows
            .partition_point(|(row_s, _)| row_s + delay_s <= t_s);
        next.checked_sub(1).map_or([0.0; 2], |at| self.rows[at].1)
    }

    /// The drive from `state` on for `h` seconds in which no other command takes hold.
    pub(crate) fn drive(&self, physics: &Physics, state: &State, h: f64) -> Drive {
        let (t, end) = (state.t_s, state.t_s + h);
        let limit = match self.quantity {
            Quantity::Torque => Some(0),
            Quantity::Speed => Some(1),
            Quantity::Voltage => None,
        };
        let told = self
            .held(t + h / 2.0, physics.delay_s)
            .map(|value| match limit {
                Some(at) if value.abs() < physics.dead_band[at] => 0.0,
                Some(at) => value.clamp(-physics.saturation[at], physics.saturation[at]),
                None => value,
            });
        // exact decay towards what was told: at the end, and its mean
        let (left, mean) = if physics.lag_s > 0.0 {
            let fade = -h / physics.lag_s;
            (
                fade.exp(),
                if fade == 0.0 {
                    1.0
                } else {
                    fade.exp_m1() / fade
                },
            )
        } else {
            (0.0, 0.0)
        };
        let toward = |share: f64| [0, 1].map(|i| told[i] + (state.lagged[i] - told[i]) * share);
        let begin = if physics.lag_s > 0.0 {
            state.lagged
        } else {
            told
        };
        let lagged = toward(left);
        let strength = |t: f64| {
            physics
                .gain
                .map(|gain| gain * (1.0 - physics.sag_per_s * t))
        };
        let scaled = |value: [f64; 2], t: f64| [0, 1].map(|i| value[i] * strength(t)[i]);
        let driven = scaled(toward(mean), (t + end) / 2.0);
        let (torque, speed) = match self.quantity {
            Quantity::Torque => (driven, None),
            Quantity::Voltage => (driven.map(|volts| volts * physics.per_volt), None),
            Quantity::Speed => ([0.0; 2], Some([scaled(begin, t), scaled(lagged, end)])),
        };
        Drive {
            torque,
            speed,
            lagged,
        }
    }

    /// Torque lost for each rad/s (N m s/rad).
    pub(crate) fn loss(&self, physics: &Physics) -> f64 {
        match self.quantity {
            Quantity::Voltage => physics.droop + physics.back_emf,
            Quantity::Torque | Quantity::Speed => physics.droop,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_bus::RobotModel;

    #[test]
    fn the_chain_has_the_contracts_order() {
        let model = RobotModel::default()
            .with("actuator_delay", &[("delay_s", 0.01)])
            .with("command_dead_band", &[("torque_nm", 0.02)])
            .with("command_saturation", &[("torque_nm", 0.05)])
            .with("motor_gain", &[("right", 2.0), ("left", 1.0)])
            .with("supply_sag", &[("rate_per_s", 0.1)]);
        let physics = Physics::new(&model).unwrap();
        let commands = Commands {
            quantity: Quantity::Torque,
            rows: vec![(0.0, [0.08, 0.019]), (1.0, [0.0, 0.0])],
        };
        let at = |t_s: f64| {
            let state = State {
                t_s,
                ..State::at([0.0; 3])
            };
            commands.drive(&physics, &state, 1e-6).torque
        };
        assert_eq!(at(0.005), [0.0; 2]);
        assert!((at(1.0)[0] - 0.05 * 2.0 * 0.9).abs() < 1e-7);
        assert!(at(1.0)[1].abs() < 1e-12);
        assert_eq!(at(1.011), [0.0; 2]);
        assert!((commands.next_s(0.5, 0.01) - 1.01).abs() < 1e-12);
    }

    #[test]
    fn a_lag_decays() {
        let model = RobotModel::default().with("actuator_lag", &[("time_constant_s", 0.1)]);
        let physics = Physics::new(&model).unwrap();
        let commands = Commands {
            quantity: Quantity::Torque,
            rows: vec![(0.0, [1.0, 1.0])],
        };
        let drive = commands.drive(&physics, &State::at([0.0; 3]), 0.2);
        let left = (-2.0f64).exp();
        assert!((drive.lagged[0] - (1.0 - left)).abs() < 1e-12);
        assert!((drive.torque[0] - (1.0 - 0.5 * (1.0 - left))).abs() < 1e-12);
    }
}
