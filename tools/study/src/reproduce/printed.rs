//! The numbers that the paper prints.

/// Largest torque without slip (N m), section 3.
pub(super) const TORQUE_LIMIT_NM: f64 = 0.095;
/// Wheel acceleration at that torque (rad/s²), section 3.
pub(super) const ACCELERATION_RAD_S2: f64 = 45.0;

/// Final positions of the platoon, section 4, for r1 to r3: x (m), y (m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Finals {
    /// By odometry.
    pub(super) encoder: [[f64; 2]; 3],
    /// Measured by hand.
    pub(super) measured: [[f64; 2]; 3],
}

/// Printed final positions without and with the torque limit.
pub(super) const FINALS: [Finals; 2] = [
    Finals {
        encoder: [[4.78, 0.02], [4.17, 0.04], [3.55, 0.03]],
        measured: [[4.87, 0.24], [4.26, 0.18], [3.65, 0.42]],
    },
    Finals {
        encoder: [[4.97, 0.003], [4.36, 0.005], [3.75, 0.002]],
        measured: [[5.02, 0.07], [4.38, 0.06], [3.77, 0.06]],
    },
];

/// Initial x of the robots (m), section 4.
pub(super) const STARTS_M: [f64; 3] = [0.6096, 0.0, -0.6096];

impl Finals {
    /// Mean absolute difference of odometry and measurement along an axis (m).
    pub(super) fn mean_gap_m(&self, axis: usize) -> f64 {
        let gap = |i: usize| (self.measured[i][axis] - self.encoder[i][axis]).abs();
        (0..3).map(gap).sum::<f64>() / 3.0
    }

    /// Largest error of the measured final spacings (m).
    pub(super) fn largest_spacing_error_m(&self) -> f64 {
        let spacing = STARTS_M[0] - STARTS_M[1];
        let error = |i: usize| (self.measured[i][0] - self.measured[i + 1][0] - spacing).abs();
        error(0).max(error(1))
    }
}
