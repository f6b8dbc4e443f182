//! Torque decision of a control law: wanted and commanded torque of each wheel.

/// Torques decided at one inner tick, [right, left].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelTorques {
    /// Torques before limiting (N m).
    pub wanted_nm: [f64; 2],
    /// Commanded torques (N m).
    pub torque_nm: [f64; 2],
}

impl WheelTorques {
    /// No torque.
    pub(crate) const ZERO: Self = Self {
        wanted_nm: [0.0; 2],
        torque_nm: [0.0; 2],
    };
}
