//! The filter for other noise sizes, linear about the trajectory of a pass.

use super::gains::{Pass, start_covariance};
use super::update::{Covariance, Gain};
use super::{DISTURBANCES, DISTURBED, N, Noise, Run, SLIP};

/// Sums over the rows of one run.
pub(crate) struct Likelihood {
    /// Whitened innovations, three for each row of the run.
    pub(crate) whitened: Vec<f64>,
    /// Sum of the logs of the determinants of their covariances.
    pub(crate) log_determinant: f64,
}

/// Likelihood of `run` under `noise`; `pass` was made with other noise.
pub(crate) fn likelihood(pass: &Pass, run: &Run, noise: &Noise) -> Likelihood {
    if noise.of_wheels {
        of::<N>(pass, run, noise)
    } else {
        of::<SLIP>(pass, run, noise)
    }
}

fn of<const M: usize>(pass: &Pass, run: &Run, noise: &Noise) -> Likelihood {
    let mut covariance = Covariance::<M> {
        p: start_covariance(&run.start_deviation, noise),
    };
    let mut whitened = vec![0.0; 3 * run.rows.len()];
    let mut log_determinant = 0.0;
    // state under this noise minus state in the pass, after the update
    let mut off = [0.0; N];
    // disturbances in the pass
    let mut passed = [0.0; DISTURBANCES];
    for (place, row) in pass.rows.iter().enumerate() {
        let mut innovation = row.innovation;
        for (a, own) in innovation.iter_mut().enumerate() {
            let g = &row.step.measurement[a];
            *own -= (0..M).map(|j| g[j] * off[j]).sum::<f64>();
        }
        let mut moved = off;
        for (i, own) in moved.iter_mut().enumerate().take(M) {
            let f = &row.step.flow[i];
            *own = (0..M).map(|j| f[j] * off[j]).sum();
        }
        if row.lost {
            covariance.p = start_covariance(&run.lost_deviation, noise);
        }
        let gain = covariance.update(&row.step, &row.variance);
        let own = gain.correction(&innovation);
        let before = pass.gains[row.row].correction(&row.innovation);
        for i in 0..M {
            off[i] = moved[i] + own[i] - before[i];
        }
        let next_s = pass
            .rows
            .get(place + 1)
            .map_or(row.true_s, |next| next.true_s);
        let decay = noise.decay(next_s - row.true_s);
        for k in 0..DISTURBANCES {
            // the disturbance of the pass decays by its own time, the other by the new one
            passed[k] += before[DISTURBED + k];
            off[DISTURBED + k] =
                (off[DISTURBED + k] + passed[k]) * decay[k] - passed[k] * row.decay[k];
            passed[k] *= row.decay[k];
        }
        covariance.disturb(noise, &decay);
        if row.gusty {
            covariance.push(&run.lost_deviation);
        }
        write(&mut whitened, row.row, &gain, &innovation);
        log_determinant += gain.log_determinant;
    }
    Likelihood {
        whitened,
        log_determinant,
    }
}

pub(super) fn write(whitened: &mut [f64], row: usize, gain: &Gain, innovation: &[f64; 3]) {
    whitened[3 * row..3 * row + 3].copy_from_slice(&gain.whitened(innovation));
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use crate::explain::dynamic::machine::Machine;
    use crate::filter::dynamic::Noise;
    use crate::filter::dynamic::linear::likelihood;
    use crate::predict::fixture;

    fn noise(surge: f64, yaw: f64, time_s: f64) -> Noise {
        Noise {
            size: [surge, yaw, 1e-4, 1e-3, 1e-4],
            time_s: [time_s; 3],
            of_wheels: false,
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
        assert!((same.log_determinant - fit.log_determinant()).abs() < 1e-8);
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
        let off = linear.log_determinant - exact.log_determinant();
        assert!(off.abs() < 0.5, "{off}");
    }
}
