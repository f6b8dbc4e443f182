//! The filter for other noise sizes, linear about the trajectory of a pass.

use super::gains::{Pass, Passed, start_covariance};
use super::update::{Covariance, Gain};
use super::{DISTURBANCES, DISTURBED, N, Noise, Run, SLIP};

/// Sums over the rows of one run.
pub(crate) struct Likelihood {
    /// Whitened innovations, three for each row of the run.
    pub(crate) whitened: Vec<f64>,
    /// Inverse of the lower Cholesky factor of the covariance of each row of the run.
    pub(crate) whitening: Vec<[[f64; 3]; 3]>,
    /// Logs of the determinants of these covariances.
    pub(crate) log_determinants: Vec<f64>,
}

/// Likelihood of `run` under `noise`, which acts on the same as that with which `pass` was made.
pub(crate) fn likelihood(pass: &Pass, run: &Run, noise: &Noise) -> Likelihood {
    if noise.of_wheels {
        of::<N>(pass, run, noise)
    } else {
        of::<SLIP>(pass, run, noise)
    }
}

fn of<const M: usize>(pass: &Pass, run: &Run, noise: &Noise) -> Likelihood {
    let mut filter: Filter<'_, M> = Filter::new(run, noise);
    for (place, row) in pass.rows.iter().enumerate() {
        let next = pass.rows.get(place + 1);
        let until_next_s = next.map_or(0.0, |next| next.true_s - row.true_s);
        let before = pass.gains[row.row].correction(&row.innovation);
        filter.hear(run, row, &before, until_next_s);
    }
    filter.out
}

/// The filter under one noise on its way through a pass.
struct Filter<'a, const M: usize> {
    noise: &'a Noise,
    covariance: Covariance<M>,
    /// State under this noise minus state in the pass, after the update.
    off: [f64; N],
    /// Disturbances in the pass.
    passed: [f64; DISTURBANCES],
    out: Likelihood,
}

impl<'a, const M: usize> Filter<'a, M> {
    fn new(run: &Run, noise: &'a Noise) -> Self {
        Self {
            noise,
            covariance: Covariance {
                p: start_covariance(&run.start_deviation, noise),
            },
            off: [0.0; N],
            passed: [0.0; DISTURBANCES],
            out: Likelihood {
                whitened: vec![0.0; 3 * run.rows.len()],
                whitening: vec![[[0.0; 3]; 3]; run.rows.len()],
                log_determinants: vec![0.0; run.rows.len()],
            },
        }
    }

    /// One row, which the pass has corrected by `before`.
    fn hear(&mut self, run: &Run, row: &Passed, before: &[f64; N], until_next_s: f64) {
        let mut innovation = row.innovation;
        for (own, g) in innovation.iter_mut().zip(&row.step.measurement) {
            *own -= (0..M).map(|j| g[j] * self.off[j]).sum::<f64>();
        }
        if row.lost {
            self.covariance.p = start_covariance(&run.lost_deviation, self.noise);
        }
        let moved = Covariance::<M>::moved(&row.step.flow, &self.off);
        let variance = row.variance(run, self.noise);
        let gain = self.covariance.update(&row.step, &variance);
        let own = gain.correction(&innovation);
        for i in 0..M {
            self.off[i] = moved[i] + own[i] - before[i];
        }
        let decay = self.noise.decay(until_next_s);
        for (k, decay) in decay.iter().enumerate() {
            // the disturbance of the pass decays by its own time, the other by the new one
            let (passed, off) = (&mut self.passed[k], &mut self.off[DISTURBED + k]);
            *passed += before[DISTURBED + k];
            *off = (*off + *passed) * decay - *passed * row.decay[k];
            *passed *= row.decay[k];
        }
        self.covariance.disturb(self.noise, &decay);
        if row.gusty {
            self.covariance.push(&run.lost_deviation);
        }
        write(&mut self.out.whitened, row.row, &gain, &innovation);
        self.out.whitening[row.row] = gain.whitening;
        self.out.log_determinants[row.row] = gain.log_determinant;
    }
}

pub(super) fn write(whitened: &mut [f64], row: usize, gain: &Gain, innovation: &[f64; 3]) {
    whitened[3 * row..3 * row + 3].copy_from_slice(&gain.whitened(innovation));
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use crate::filter::dynamic::Noise;
    use crate::filter::dynamic::linear::likelihood;
    use crate::model::plant::machine::Machine;
    use crate::predict::fixture;

    fn noise(surge: f64, yaw: f64, time_s: f64) -> Noise {
        Noise {
            size: [surge, yaw, 1e-4, 1e-3, 1e-4],
            time_s: [time_s; 3],
            of_wheels: false,
            jitter_s: 0.0,
            beyond: [0.0; 3],
        }
    }

    /// The largest difference between two series.
    fn apart(a: &[f64], b: &[f64]) -> f64 {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn under_the_noise_of_the_pass_it_is_the_pass() {
        let truth = RobotModel::default().with("viscous_drag", &[("coefficient", 0.3)]);
        let track = fixture::driven(&truth, 8.0, fixture::gentle);
        let machine = Machine::new(vec![track], RobotModel::default(), &[]);
        let own = noise(0.05, 2e-3, 0.3);
        let fit = machine.pass(Vec::new(), own).unwrap();
        let same = likelihood(&fit.passes[0], &machine.runs[0], &own);
        // the same operations up to their order: rounding alone
        assert!(apart(&same.whitened, &fit.whitened) < 1e-8);
        assert!((same.log_determinants.iter().sum::<f64>() - fit.log_determinant()).abs() < 1e-8);
    }

    #[test]
    fn under_other_noise_it_is_the_filter_to_first_order() {
        let truth = RobotModel::default().with("viscous_drag", &[("coefficient", 0.3)]);
        let track = fixture::driven(&truth, 8.0, fixture::gentle);
        let machine = Machine::new(vec![track], RobotModel::default(), &[]);
        let fit = machine.pass(Vec::new(), noise(0.05, 2e-3, 0.3)).unwrap();
        let other = noise(0.1, 1e-3, 0.1);
        let linear = likelihood(&fit.passes[0], &machine.runs[0], &other);
        let exact = machine.pass(Vec::new(), other).unwrap();
        let largest = apart(&exact.whitened, &vec![0.0; exact.whitened.len()]);
        // the trajectories differ by a small part of what is not linear in them
        assert!(apart(&linear.whitened, &exact.whitened) < 0.05 * largest);
        let off = linear.log_determinants.iter().sum::<f64>() - exact.log_determinant();
        assert!(off.abs() < 0.5, "{off}");
    }
}
