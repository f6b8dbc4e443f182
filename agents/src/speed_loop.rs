//! Inner loop: PI speed controller of each wheel (section 3 of the paper), with anti-windup.

use slipstream_bus::experiment::Control;

use crate::wheel_torques::WheelTorques;

/// The speed loops of both wheels.
#[derive(Debug, Clone, Copy, Default)]
pub struct SpeedLoops {
    /// Integral terms (N m).
    integral_nm: [f64; 2],
}

impl SpeedLoops {
    /// One tick: torques from measured speeds and set-points (rad/s), limited to `limit_nm`.
    ///
    /// Anti-windup by conditional integration: the integral term stays while the torque is limited
    /// and the error would increase the excess.
    pub fn step(
        &mut self,
        speed: [f64; 2],
        set_point: [f64; 2],
        limit_nm: [f64; 2],
        control: &Control,
    ) -> WheelTorques {
        let mut wanted_nm = [0.0; 2];
        let mut torque_nm = [0.0; 2];
        for i in 0..2 {
            let error = set_point[i] - speed[i];
            wanted_nm[i] = control.k_p * error + self.integral_nm[i];
            torque_nm[i] = wanted_nm[i].clamp(-limit_nm[i], limit_nm[i]);
            let winds_up = (wanted_nm[i] - torque_nm[i]) * error > 0.0;
            if !winds_up {
                self.integral_nm[i] += control.k_i * control.inner_period_s * error;
            }
        }
        WheelTorques {
            wanted_nm,
            torque_nm,
        }
    }

    /// The set-points nearest to `set_point` (rad/s) for which the next tick wants no more than
    /// `limit_nm`, provided that the speeds (rad/s) change by at most `drift` (rad/s) until then.
    /// Later ticks want less, because the speeds approach the set-points.
    pub fn within_torque_limit(
        &self,
        speed: [f64; 2],
        drift: [f64; 2],
        set_point: [f64; 2],
        limit_nm: [f64; 2],
        control: &Control,
    ) -> [f64; 2] {
        [0, 1].map(|i| {
            let integral = self.integral_nm[i].clamp(-limit_nm[i], limit_nm[i]);
            let slowest = speed[i] + drift[i].min(0.0);
            let fastest = speed[i] + drift[i].max(0.0);
            let max = slowest + (limit_nm[i] - integral) / control.k_p;
            let min = fastest + (-limit_nm[i] - integral) / control.k_p;
            // No set-point satisfies both limits if the drift is large: keep the measured speed.
            if min > max {
                speed[i]
            } else {
                set_point[i].clamp(min, max)
            }
        })
    }

    /// Sets the integral terms to 0.
    pub fn reset(&mut self) {
        self.integral_nm = [0.0; 2];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limited_loop_does_not_wind_up() {
        let control = Control::default();
        let mut loops = SpeedLoops::default();
        for _ in 0..500 {
            let torque = loops.step([0.0; 2], [100.0; 2], [0.09; 2], &control);
            assert_eq!(torque.torque_nm, [0.09; 2]);
        }
        // At the set-point only the integral term is left, and it did not wind up.
        let after = loops.step([100.0; 2], [100.0; 2], [0.09; 2], &control);
        assert!(after.wanted_nm[0].abs() < 0.01, "{after:?}");
    }

    #[test]
    fn a_steady_error_is_integrated_away() {
        let control = Control::default();
        let (mut loops, mut speed) = (SpeedLoops::default(), 0.0);
        // A wheel that carries half of the paper's robot, against a constant 0.02 N m.
        for _ in 0..500 {
            let torque = loops.step([speed; 2], [10.0; 2], [0.13; 2], &control);
            speed += (torque.torque_nm[0] - 0.02) / 0.002_25 * control.inner_period_s;
        }
        assert!((speed - 10.0).abs() < 1e-6, "{speed}");
    }

    #[test]
    fn a_limited_set_point_needs_exactly_the_torque_limit() {
        let control = Control::default();
        let mut loops = SpeedLoops::default();
        loops.step([0.0; 2], [1.0, -1.0], [0.13; 2], &control);
        let set_point =
            loops.within_torque_limit([2.0, -2.0], [0.0; 2], [50.0, -50.0], [0.092; 2], &control);
        let torque = loops.step([2.0, -2.0], set_point, [1.0; 2], &control);
        assert!((torque.wanted_nm[0] - 0.092).abs() < 1e-12, "{torque:?}");
        assert!((torque.wanted_nm[1] + 0.092).abs() < 1e-12, "{torque:?}");
    }
}
