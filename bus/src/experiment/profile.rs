//! Velocity profile of the front robot, piecewise linear (Fig. 8 of the paper).

use serde::{Deserialize, Serialize};

/// Reference velocities of the front robot over time: piecewise linear between the given points,
/// constant before the first and after the last.
///
/// The default resembles Fig. 8, for which the paper prints no numbers: acceleration at 5 s,
/// deceleration from 8 s to rest at 12 s, softer than the acceleration, over 4.3 m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Times of the points (s), strictly increasing.
    pub times_s: Vec<f64>,
    /// v_r at each point (m/s).
    pub speeds_m_s: Vec<f64>,
    /// w_r at each point (rad/s).
    pub yaw_rates_rad_s: Vec<f64>,
}

impl Profile {
    /// v_r (m/s) and w_r (rad/s) at time `t_s` (s).
    pub fn at(&self, t_s: f64) -> (f64, f64) {
        let after = self.times_s.partition_point(|&t| t <= t_s);
        let value = |column: &[f64]| match (after.checked_sub(1), column.get(after)) {
            (None, first) => first.copied().unwrap_or(0.0),
            (Some(before), None) => column.get(before).copied().unwrap_or(0.0),
            (Some(before), Some(next)) => {
                let fraction =
                    (t_s - self.times_s[before]) / (self.times_s[after] - self.times_s[before]);
                column[before] + fraction * (next - column[before])
            }
        };
        (value(&self.speeds_m_s), value(&self.yaw_rates_rad_s))
    }
}
