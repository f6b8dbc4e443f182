//! An Ornstein-Uhlenbeck disturbance d and its integral x: dd = −d/τ dt + noise, dx = d dt. So err the angles of
//! wheels about their simulated course, and the yaw that wheels predict.

use slipstream_sim::Scalar;

/// The disturbance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OrnsteinUhlenbeck<S> {
    /// Its variance while nothing is known of it.
    pub(crate) variance: S,
    /// Its correlation time τ (s).
    pub(crate) time_s: S,
}

/// Transition of x and d over a step: F = [[1, reach], [0, decay]].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step<S> {
    /// What is left of a disturbance.
    pub(crate) decay: S,
    /// What a disturbance of 1 adds to its integral (s).
    pub(crate) reach_s: S,
}

impl<S: Scalar> OrnsteinUhlenbeck<S> {
    /// Transition over `h` (s).
    pub(crate) fn step(&self, h: S) -> Step<S> {
        let decay = (-h / self.time_s).exp();
        Step {
            decay,
            reach_s: self.time_s * (S::constant(1.0) - decay),
        }
    }

    /// Variance of x, covariance, and variance of d that the noise adds over `h` (s): exact.
    pub(crate) fn noise(&self, step: &Step<S>, h: S) -> [S; 3] {
        let Step { decay, reach_s } = *step;
        let one = S::constant(1.0);
        let both = self.variance * self.time_s * (one - decay) * (one - decay);
        let x = self.variance * (self.time_s * (h - reach_s) * 2.0 - reach_s * reach_s);
        // the difference of nearly equal numbers, where h is much shorter than the time constant
        let x = if x.value() > 0.0 { x } else { S::constant(0.0) };
        [x, both, self.variance * (one - decay * decay)]
    }

    /// The same to lowest order in h/τ: without a difference of nearly equal numbers, however short the step.
    pub(crate) fn noise_of_short_step(&self, step: &Step<S>, h: S) -> [S; 3] {
        let added = self.variance * (S::constant(1.0) - step.decay * step.decay);
        [added * h * h / 3.0, added * h * 0.5, added]
    }
}

/// What is known of x and d.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Integrated<S> {
    /// x and d.
    pub(crate) mean: [S; 2],
    /// Variance of x, covariance, variance of d.
    pub(crate) cov: [S; 3],
}

impl<S: Scalar> Integrated<S> {
    /// Moves on by a step, without the noise that it adds.
    pub(crate) fn advance(&mut self, step: &Step<S>) {
        let Step { decay, reach_s } = *step;
        let [x, d] = self.mean;
        self.mean = [x + reach_s * d, decay * d];
        self.cov = step.carried(self.cov);
    }

    /// Kalman update by a measurement of x, of which this was left (measured minus predicted), with this variance
    /// of what was left.
    pub(crate) fn updated(&self, difference: S, variance: S) -> Self {
        let [xx, xd, dd] = self.cov;
        let gain = [xx / variance, xd / variance];
        Self {
            mean: [0, 1].map(|i| self.mean[i] + gain[i] * difference),
            cov: [xx - gain[0] * xx, xd - gain[0] * xd, dd - gain[1] * xd],
        }
    }
}

impl<S: Scalar> Step<S> {
    /// F P Fᵀ.
    pub(crate) fn carried(&self, [xx, xd, dd]: [S; 3]) -> [S; 3] {
        let Self { decay, reach_s } = *self;
        [
            xx + reach_s * xd * 2.0 + reach_s * reach_s * dd,
            decay * (xd + reach_s * dd),
            decay * decay * dd,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OWN: OrnsteinUhlenbeck<f64> = OrnsteinUhlenbeck {
        variance: 0.09,
        time_s: 0.7,
    };

    /// The covariance after a step of `h` (s), by the exact noise.
    fn moved(cov: [f64; 3], h: f64) -> [f64; 3] {
        let step = OWN.step(h);
        let (carried, noise) = (step.carried(cov), OWN.noise(&step, h));
        std::array::from_fn(|i| carried[i] + noise[i])
    }

    #[test]
    fn two_steps_are_one_of_both_lengths() {
        let start = [0.02, -0.01, 0.04];
        let (once, twice) = (moved(start, 0.9), moved(moved(start, 0.2), 0.7));
        for i in 0..3 {
            assert!((once[i] - twice[i]).abs() < 1e-15, "{once:?} {twice:?}");
        }
    }

    #[test]
    fn the_transition_is_the_derivative_of_the_mean() {
        let step = OWN.step(0.4);
        let moved = |x: f64, d: f64| {
            let mut own = Integrated {
                mean: [x, d],
                cov: [0.0; 3],
            };
            own.advance(&step);
            own.mean
        };
        let (h, at) = (1e-6, [0.3, -0.2]);
        let by_d =
            [0, 1].map(|i| (moved(at[0], at[1] + h)[i] - moved(at[0], at[1] - h)[i]) / (2.0 * h));
        let by_x =
            [0, 1].map(|i| (moved(at[0] + h, at[1])[i] - moved(at[0] - h, at[1])[i]) / (2.0 * h));
        // F P Fᵀ of a P that is one in one place is the square of a column of F
        let [xx, xd, dd] = step.carried([0.0, 0.0, 1.0]);
        for (own, wanted) in [
            (xx, by_d[0] * by_d[0]),
            (xd, by_d[0] * by_d[1]),
            (dd, by_d[1] * by_d[1]),
        ] {
            assert!((own - wanted).abs() < 1e-9, "{own} {wanted}");
        }
        assert!((by_x[0] - 1.0).abs() < 1e-9 && by_x[1].abs() < 1e-9);
    }

    #[test]
    fn a_short_step_adds_the_same_by_both() {
        let (h, off) = (0.007, 0.01);
        let step = OWN.step(h);
        let both = [OWN.noise(&step, h), OWN.noise_of_short_step(&step, h)];
        for (exact, short) in both[0].iter().zip(both[1]) {
            assert!((short / exact - 1.0).abs() < off, "{exact} {short}");
        }
    }

    #[test]
    fn an_update_is_that_of_the_textbook() {
        let own = Integrated::<f64> {
            mean: [1.0, 0.5],
            cov: [0.3, 0.1, 0.2],
        };
        let (sensor, measured) = (0.2, 1.4);
        let after = own.updated(measured - 1.0, 0.3 + sensor);
        // by information: P⁻¹ + Hᵀ H / R
        let det = 0.3 * 0.2 - 0.1 * 0.1;
        let information = [0.2 / det + 1.0 / sensor, -0.1 / det, 0.3 / det];
        let det = information[0] * information[2] - information[1] * information[1];
        let wanted = [
            information[2] / det,
            -information[1] / det,
            information[0] / det,
        ];
        for (own, wanted) in after.cov.iter().zip(wanted) {
            assert!((own - wanted).abs() < 1e-12, "{after:?}");
        }
        assert!((after.mean[0] - (1.0 + wanted[0] / sensor * 0.4)).abs() < 1e-12);
        assert!((after.mean[1] - (0.5 + wanted[1] / sensor * 0.4)).abs() < 1e-12);
    }
}
