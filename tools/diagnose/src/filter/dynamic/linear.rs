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
