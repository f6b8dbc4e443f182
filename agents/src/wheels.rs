//! The inner loop: a PI controller for the speed of each wheel, 50 Hz in the paper.

use slipstream_bus::experiment::Control;

/// The loops of both wheels.
#[derive(Debug, Clone, Default)]
pub struct WheelLoops {
    /// What the integrators hold (N m).
    integral_nm: [f64; 2],
}

/// What the loops decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelTorque {
    /// Asked for, before limiting (N m).
    pub wanted_nm: [f64; 2],
    /// Commanded (N m).
    pub torque_nm: [f64; 2],
}

impl WheelLoops {
    /// One tick: speeds (rad/s) against set-points (rad/s), within `limit_nm`.
    ///
    /// Anti-windup: an integrator stands still while its wheel's torque is limited and the error
    /// would drive it further out.
    pub fn step(
        &mut self,
        speed: [f64; 2],
        set_point: [f64; 2],
        limit_nm: [f64; 2],
        control: &Control,
    ) -> WheelTorque {
        let mut wanted_nm = [0.0; 2];
        let mut torque_nm = [0.0; 2];
        for i in 0..2 {
            let error = set_point[i] - speed[i];
            wanted_nm[i] = control.k_p * error + self.integral_nm[i];
            torque_nm[i] = wanted_nm[i].clamp(-limit_nm[i], limit_nm[i]);
            let outwards = (wanted_nm[i] - torque_nm[i]) * error > 0.0;
            if !outwards {
                self.integral_nm[i] += control.k_i * control.inner_period_s * error;
            }
        }
        WheelTorque {
            wanted_nm,
            torque_nm,
        }
    }

    /// The set-points nearest to `set_point` (rad/s) for which the next tick asks for no more than
    /// `limit_nm`, if until then the speeds (rad/s) drift by no more than `drift` (rad/s). The wheels
    /// then only come closer, so that later ticks ask for less.
    pub fn reachable(
        &self,
        speed: [f64; 2],
        drift: [f64; 2],
        set_point: [f64; 2],
        limit_nm: [f64; 2],
        control: &Control,
    ) -> [f64; 2] {
        [0, 1].map(|i| {
            let held = self.integral_nm[i].clamp(-limit_nm[i], limit_nm[i]);
            let slowest = speed[i] + drift[i].min(0.0);
            let fastest = speed[i] + drift[i].max(0.0);
            let most = slowest + (limit_nm[i] - held) / control.k_p;
            let least = fastest + (-limit_nm[i] - held) / control.k_p;
            // Where the drift leaves no room, what the wheels do anyway.
            if least > most {
                speed[i]
            } else {
                set_point[i].clamp(least, most)
            }
        })
    }

    /// Forgets what the integrators hold.
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
        let mut loops = WheelLoops::default();
        for _ in 0..500 {
            let torque = loops.step([0.0; 2], [100.0; 2], [0.09; 2], &control);
            assert_eq!(torque.torque_nm, [0.09; 2]);
        }
        // The set-point is reached: without windup nothing is left to give back.
        let after = loops.step([100.0; 2], [100.0; 2], [0.09; 2], &control);
        assert!(after.wanted_nm[0].abs() < 0.01, "{after:?}");
    }

    #[test]
    fn a_steady_error_is_integrated_away() {
        let control = Control::default();
        let (mut loops, mut speed) = (WheelLoops::default(), 0.0);
        // A wheel with the straight-line inertia of the paper's robot against a constant 0.02 N m.
        for _ in 0..500 {
            let torque = loops.step([speed; 2], [10.0; 2], [0.13; 2], &control);
            speed += (torque.torque_nm[0] - 0.02) / 0.002_25 * control.inner_period_s;
        }
        assert!((speed - 10.0).abs() < 1e-6, "{speed}");
    }

    #[test]
    fn a_reachable_set_point_needs_no_more_than_the_limit() {
        let control = Control::default();
        let mut loops = WheelLoops::default();
        loops.step([0.0; 2], [1.0, -1.0], [0.13; 2], &control);
        let set_point = loops.reachable([2.0, -2.0], [0.0; 2], [50.0, -50.0], [0.092; 2], &control);
        let torque = loops.step([2.0, -2.0], set_point, [1.0; 2], &control);
        assert!((torque.wanted_nm[0] - 0.092).abs() < 1e-12, "{torque:?}");
        assert!((torque.wanted_nm[1] + 0.092).abs() < 1e-12, "{torque:?}");
    }
}
