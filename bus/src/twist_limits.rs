//! Limits of the twists that a robot is told: speeds and accelerations.

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::range::{self, within};

/// Largest speeds and accelerations of v_d and w_d, of either sign.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwistLimits {
    /// Forward speed (m/s).
    pub speed_m_s: f64,
    /// Yaw rate (rad/s).
    pub yaw_rate_rad_s: f64,
    /// Change of the forward speed (m/s²).
    pub acceleration_m_s2: f64,
    /// Change of the yaw rate (rad/s²).
    pub yaw_acceleration_rad_s2: f64,
}

impl TwistLimits {
    /// No limits that a robot on a floor reaches: the ends of the [`range`]s.
    pub const NONE: Self = Self {
        speed_m_s: range::SPEED_M_S[1],
        yaw_rate_rad_s: range::YAW_RATE_RAD_S[1],
        acceleration_m_s2: range::ACCELERATION_M_S2[1],
        yaw_acceleration_rad_s2: range::YAW_ACCELERATION_RAD_S2[1],
    };

    /// The twist [v (m/s), w (rad/s)] nearest to `wanted` that may follow `last` after `after_s` (s). A number that is none
    /// counts as 0.
    #[must_use]
    pub fn cut(&self, wanted: [f64; 2], last: [f64; 2], after_s: f64) -> [f64; 2] {
        let largest = [self.speed_m_s, self.yaw_rate_rad_s];
        let steepest = [self.acceleration_m_s2, self.yaw_acceleration_rad_s2];
        std::array::from_fn(|i| {
            let wanted = if wanted[i].is_finite() {
                wanted[i]
            } else {
                0.0
            };
            let step = steepest[i] * after_s.max(0.0);
            let reached = wanted.clamp(last[i] - step, last[i] + step);
            reached.clamp(-largest[i], largest[i])
        })
    }

    /// The smaller one of each limit.
    #[must_use]
    pub fn both(&self, other: &Self) -> Self {
        Self {
            speed_m_s: self.speed_m_s.min(other.speed_m_s),
            yaw_rate_rad_s: self.yaw_rate_rad_s.min(other.yaw_rate_rad_s),
            acceleration_m_s2: self.acceleration_m_s2.min(other.acceleration_m_s2),
            yaw_acceleration_rad_s2: self
                .yaw_acceleration_rad_s2
                .min(other.yaw_acceleration_rad_s2),
        }
    }

    /// Checks that all limits are positive and finite. `place` names the table in errors.
    ///
    /// # Errors
    /// The first limit that no robot has.
    pub fn validate(&self, place: &str) -> Result<(), InputError> {
        let least = |range: range::Range| [1e-6, range[1]];
        for (key, value, range) in [
            ("speed_m_s", self.speed_m_s, least(range::SPEED_M_S)),
            (
                "yaw_rate_rad_s",
                self.yaw_rate_rad_s,
                least(range::YAW_RATE_RAD_S),
            ),
            (
                "acceleration_m_s2",
                self.acceleration_m_s2,
                range::ACCELERATION_M_S2,
            ),
            (
                "yaw_acceleration_rad_s2",
                self.yaw_acceleration_rad_s2,
                range::YAW_ACCELERATION_RAD_S2,
            ),
        ] {
            within(&format!("{place}.{key}"), value, range)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: TwistLimits = TwistLimits {
        speed_m_s: 0.5,
        yaw_rate_rad_s: 2.0,
        acceleration_m_s2: 1.0,
        yaw_acceleration_rad_s2: 10.0,
    };

    #[test]
    fn a_twist_reaches_its_limits_step_by_step() {
        let mut twist = [0.0; 2];
        for step in 1..=20 {
            twist = LIMITS.cut([3.0, -9.0], twist, 0.05);
            let step = f64::from(step);
            assert!((twist[0] - (0.05 * step).min(0.5)).abs() < 1e-12);
            assert!((twist[1] + (0.5 * step).min(2.0)).abs() < 1e-12);
        }
        // What comes from outside of the limits returns at once.
        assert_eq!(LIMITS.cut([0.0, 0.0], [9.0, 0.0], 0.05), [0.5, 0.0]);
    }

    #[test]
    fn what_is_no_number_stops() {
        assert_eq!(
            LIMITS.cut([f64::NAN, f64::INFINITY], [0.02, 0.1], 0.05),
            [0.0; 2]
        );
        assert_eq!(LIMITS.cut([0.3, 0.0], [0.1, 0.0], -1.0), [0.1, 0.0]);
        assert_eq!(
            TwistLimits::NONE.cut([0.7, 3.0], [0.0; 2], 0.05),
            [0.7, 3.0]
        );
    }

    #[test]
    fn an_invalid_limit_names_its_key() {
        let wrong = TwistLimits {
            yaw_acceleration_rad_s2: 0.0,
            ..LIMITS
        };
        assert_eq!(LIMITS.validate("limits"), Ok(()));
        let place = wrong.validate("limits").unwrap_err().place;
        assert_eq!(place, "limits.yaw_acceleration_rad_s2");
        assert_eq!(LIMITS.both(&TwistLimits::NONE), LIMITS);
    }
}
