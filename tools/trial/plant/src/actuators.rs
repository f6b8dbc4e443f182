//! Actuators, from command to torque or speed: delay, dead band, dead zone, saturation, lag, gain, supply
//! sag. The dead zone takes a constant size off the command times the gain.

use crate::physics::Physics;
use crate::state::State;

/// The quantity that a command sets.
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
    /// The quantity.
    pub quantity: Quantity,
    /// Time (s) and value; a command holds until the next.
    pub rows: Vec<(f64, [f64; 2])>,
}

/// The drive over one step; pairs are [right, left].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drive {
    /// Mean torque before speed-dependent losses (N m).
    pub(crate) torque: [f64; 2],
    /// Prescribed speeds at the start and the end of the step (rad/s).
    pub(crate) speed: Option<[[f64; 2]; 2]>,
    /// The lagged command at the end of the step.
    pub(crate) lagged: [f64; 2],
}

impl Commands {
    /// Wheel speeds [right, left] (rad/s) of a twist [m/s, rad/s], with nominal radius and half track (m).
    pub fn wheel_speeds([v, w]: [f64; 2], [radius, half_track]: [f64; 2]) -> [f64; 2] {
        [(v + half_track * w) / radius, (v - half_track * w) / radius]
    }

    /// The first time after `t_s` at which a new command takes effect (s).
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

    /// The drive from `state` on over `h` (s), during which no new command takes effect.
    pub(crate) fn drive(&self, physics: &Physics, state: &State, h: f64) -> Drive {
        let (t, end) = (state.t_s, state.t_s + h);
        let limit = match self.quantity {
            Quantity::Torque => Some(0),
            Quantity::Speed => Some(1),
            Quantity::Voltage => None,
        };
        let lost = self.lost(physics);
        let held = self.held(t + h / 2.0, physics.delay_s);
        let command = [0, 1].map(|i| match limit {
            Some(at) if held[i].abs() < physics.dead_band[at] => 0.0,
            Some(at) => behind_zone(held[i], physics.gain[i], lost)
                .clamp(-physics.saturation[at], physics.saturation[at]),
            None => behind_zone(held[i], physics.gain[i], lost),
        });
        // Exact exponential decay towards the command: its value at the end and its mean.
        let (decay, mean) = if physics.lag_s > 0.0 {
            let exponent = -h / physics.lag_s;
            (
                exponent.exp(),
                if exponent == 0.0 {
                    1.0
                } else {
                    exponent.exp_m1() / exponent
                },
            )
        } else {
            (0.0, 0.0)
        };
        let toward =
            |share: f64| [0, 1].map(|i| command[i] + (state.lagged[i] - command[i]) * share);
        let begin = if physics.lag_s > 0.0 {
            state.lagged
        } else {
            command
        };
        let lagged = toward(decay);
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

    /// What the dead zone takes off the command times the gain, in the unit of the command. One that is
    /// given as a torque takes the voltage of that torque off a voltage.
    fn lost(&self, physics: &Physics) -> f64 {
        let [torque, voltage, speed] = physics.dead_zone;
        match self.quantity {
            Quantity::Torque => torque,
            Quantity::Voltage if torque > 0.0 => torque / physics.per_volt,
            Quantity::Voltage => voltage,
            Quantity::Speed => speed,
        }
    }

    /// Torque lost per wheel speed (N m s/rad).
    pub(crate) fn loss(&self, physics: &Physics) -> f64 {
        match self.quantity {
            Quantity::Voltage => physics.droop + physics.back_emf,
            Quantity::Torque | Quantity::Speed => physics.droop,
        }
    }
}

/// The command that, times the gain, is what a dead zone leaves of `value` times the gain.
fn behind_zone(value: f64, gain: f64, lost: f64) -> f64 {
    if lost == 0.0 {
        return value;
    }
    let left = (value.abs() * gain - lost).max(0.0);
    if left == 0.0 {
        0.0
    } else {
        (left / gain).copysign(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_bus::RobotModel;

    #[test]
    fn effects_act_in_the_documented_order() {
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
