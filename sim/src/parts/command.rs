//! Commands to the two wheels: torque, voltage, wheel speed or twist.

use super::scalar::{Pair, Scalar};

/// A command to both wheels, held until the next one. Fields with derivatives carry them through
/// the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command<S = f64> {
    /// Torque at the wheels (no motor curve).
    Torque {
        /// Right wheel (N m).
        right_nm: S,
        /// Left wheel (N m).
        left_nm: S,
    },
    /// Voltage at the motors: τ = τ_stall V / V_nominal − (τ_stall / ω_0) ω. Of a robot whose masses are unknown the
    /// wheels turn as fast as motors without a load: ω = ω_0 V / V_nominal.
    Voltage {
        /// Right motor (V).
        right_v: S,
        /// Left motor (V).
        left_v: S,
    },
    /// Speeds of the wheels, followed exactly and without motor dynamics; effects on the command act
    /// first.
    Speed {
        /// Right wheel (rad/s).
        right_rad_s: S,
        /// Left wheel (rad/s).
        left_rad_s: S,
    },
    /// Twist of the robot, turned into wheel speeds (v ± b w) / r by the nominal b and r, which are
    /// followed as those of `Speed`.
    Twist {
        /// Forward speed (m/s).
        v_m_s: S,
        /// Yaw rate (rad/s).
        w_rad_s: S,
    },
}

/// The quantity that a command prescribes at the wheels. A twist prescribes wheel speeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandKind {
    /// Torque (N m).
    Torque,
    /// Voltage (V).
    Voltage,
    /// Wheel speed (rad/s).
    Speed,
}

impl CommandKind {
    /// The kind's name in error messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Torque => "torque",
            Self::Voltage => "voltage",
            Self::Speed => "speed",
        }
    }
}

impl<S: Scalar> Command<S> {
    /// Zero torque at both wheels: the robot coasts.
    pub fn zero_torque() -> Self {
        let zero = S::constant(0.0);
        Self::Torque {
            right_nm: zero,
            left_nm: zero,
        }
    }

    /// The prescribed quantity and its value at the right and the left wheel. `nominal` = [r, b]
    /// (m).
    pub(crate) fn at_wheels(&self, nominal: Pair<f64>) -> (CommandKind, Pair<S>) {
        match *self {
            Self::Torque { right_nm, left_nm } => (CommandKind::Torque, [right_nm, left_nm]),
            Self::Voltage { right_v, left_v } => (CommandKind::Voltage, [right_v, left_v]),
            Self::Speed {
                right_rad_s,
                left_rad_s,
            } => (CommandKind::Speed, [right_rad_s, left_rad_s]),
            Self::Twist { v_m_s, w_rad_s } => {
                let [r, b] = nominal;
                let turn = w_rad_s * b;
                (CommandKind::Speed, [(v_m_s + turn) / r, (v_m_s - turn) / r])
            }
        }
    }
}
