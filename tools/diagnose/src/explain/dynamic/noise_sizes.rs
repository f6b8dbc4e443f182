//! Sizes and correlation times of the disturbances, by maximum likelihood: Fisher scoring in their
//! logarithms (Longford 1987), each evaluation one linear filter.
//!
//! A size and its time trade along a ridge (time up, size down), which the information matrix knows.
//! A size may fall to its floor: the difference between two integrators of one model. There the
//! likelihood is flat in its logarithm, so that other sizes are tried one by one.

use nalgebra::{DMatrix, DVector};

use crate::filter::dynamic::Noise;

/// Largest sizes, in the units of [`Noise`].
const LARGEST: [f64; 5] = [30.0, 1.0, 1.0, 3.0, 1.0];
/// Shortest and longest correlation time (s).
const TIMES_S: [f64; 2] = [0.01, 10.0];
/// Logs of sizes and times: five and three.
const LENGTH: usize = 8;
type Logs = [f64; LENGTH];

/// How far a search goes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Most steps of scoring.
    pub(crate) steps: usize,
    /// Gain in −2 ln L below which a step ends the search, or is not taken.
    pub(crate) gain: f64,
    /// Whether sizes at their floor are tried at others, and others at their floor.
    pub(crate) thorough: bool,
}

pub(crate) const QUICK: Effort = Effort {
    steps: 2,
    gain: 1.0,
    thorough: false,
};
pub(crate) const THOROUGH: Effort = Effort {
    steps: 10,
    gain: 0.3,
    thorough: true,
};

/// Steps by which a size at its floor is raised (logarithms).
const RAISED: [f64; 3] = [1.5, 3.5, 5.5];
/// What a size above its floor has to gain in −2 ln L: as much as a parameter of no use does (Akaike).
const WORTH: f64 = 2.0;
/// Above its floor by less, a size is at its floor (logarithms).
const AT_FLOOR: f64 = 0.02;
/// Step of the differences by which the filter is differentiated (logarithms).
const DIFFERENCE: f64 = 1e-3;
/// Longest steps of scoring up and down (logarithms), and how often a step that fails is shortened.
const LONGEST: [f64; 2] = [1.5, 3.0];
const SHORTENED: usize = 3;

/// What the filter says under some noise.
#[derive(Default)]
pub(crate) struct Sample {
    /// −2 ln L.
    pub(crate) deviance: f64,
    /// Whitened innovations, three for each row, and one over the level of each.
    pub(crate) whitened: Vec<f64>,
    pub(crate) precision: Vec<f64>,
    /// Inverse of the lower Cholesky factor of each row's covariance.
    pub(crate) whitening: Vec<[[f64; 3]; 3]>,
}

/// A search over the noise of one model.
pub(crate) struct Search<'a> {
    pub(crate) floor: [f64; 5],
    pub(crate) of_wheels: bool,
    pub(crate) has_pose: bool,
    /// The filter under each of several kinds of noise.
    pub(crate) samples: &'a dyn Fn(&[Noise]) -> Vec<Sample>,
}

/// Where a search is.
struct At {
    logs: Logs,
    sample: Sample,
}

impl Search<'_> {
    fn noise(&self, logs: &Logs) -> Noise {
        Noise {
            size: std::array::from_fn(|i| logs[i].exp()),
            time_s: std::array::from_fn(|i| logs[5 + i].exp()),
            of_wheels: self.of_wheels,
        }
    }

    fn held(&self, mut logs: Logs) -> Logs {
        for (i, own) in logs.iter_mut().enumerate() {
            let [low, high] = if i < 5 {
                [self.floor[i], LARGEST[i]]
            } else {
                TIMES_S
            };
            *own = own.clamp(low.ln(), high.ln());
        }
        if self.of_wheels {
            logs[3] = logs[2];
        }
        logs
    }

    /// Sizes that are searched, each with its time.
    fn pairs(&self) -> &'static [(usize, usize)] {
        match (self.of_wheels, self.has_pose) {
            (false, true) => &[(0, 5), (1, 6), (2, 7), (3, 7), (4, 7)],
            (true, true) => &[(0, 5), (1, 6), (2, 7), (4, 7)],
            (false, false) => &[(0, 5), (1, 6)],
            (true, false) => &[(0, 5), (1, 6), (2, 7)],
        }
    }

    /// Improves `from`. Returns the noise and its −2 ln L.
    pub(crate) fn run(&self, from: &Noise, effort: Effort) -> (Noise, f64) {
        let mut logs = [0.0; LENGTH];
        for (own, size) in logs.iter_mut().zip(from.size) {
            *own = size.max(1e-12).ln();
        }
        for (own, time_s) in logs[5..].iter_mut().zip(from.time_s) {
            *own = time_s.ln();
        }
        let mut at = self.at(self.held(logs));
        let mut damping = 1e-3;
        if effort.thorough {
            self.wake(&mut at);
        }
        for _ in 0..effort.steps {
            if self.score(&mut at, &mut damping, effort.gain) < effort.gain {
                break;
            }
        }
        if effort.thorough {
            self.rest(&mut at);
        }
        (self.noise(&at.logs), at.sample.deviance)
    }

    fn at(&self, logs: Logs) -> At {
        let sample = (self.samples)(&[self.noise(&logs)]).pop();
        let sample = sample.unwrap_or_default();
        At { logs, sample }
    }

    fn is_at_floor(&self, logs: &Logs, size: usize) -> bool {
        logs[size] <= self.floor[size].ln() + AT_FLOOR
    }

    /// Goes to `logs` if that gains as much.
    fn take(&self, at: &mut At, logs: Logs, gain: f64) -> bool {
        let next = self.at(self.held(logs));
        let better = next.sample.deviance < at.sample.deviance - gain;
        if better {
            *at = next;
        }
        better
    }

    /// Raises sizes that are at their floor, where that gains.
    fn wake(&self, at: &mut At) {
        for &(size, _) in self.pairs() {
            if !self.is_at_floor(&at.logs, size) {
                continue;
            }
            let raised = RAISED.map(|up| {
                let mut logs = at.logs;
                logs[size] += up;
                self.held(logs)
            });
            let samples = (self.samples)(&raised.map(|logs| self.noise(&logs)));
            let each = raised.into_iter().zip(samples);
            let best = each.min_by(|a, b| a.1.deviance.total_cmp(&b.1.deviance));
            if let Some((logs, sample)) = best
                && sample.deviance < at.sample.deviance - WORTH
            {
                *at = At { logs, sample };
            }
        }
    }

    /// Lets sizes fall to their floor where that costs next to nothing.
    fn rest(&self, at: &mut At) {
        for &(size, _) in self.pairs() {
            if !self.is_at_floor(&at.logs, size) {
                let mut logs = at.logs;
                logs[size] = self.floor[size].ln();
                self.take(at, logs, -WORTH);
            }
        }
    }

    /// What is not at its floor, and the times of that.
    fn free(&self, logs: &Logs) -> Vec<usize> {
        let awake = |&&(size, _): &&(usize, usize)| !self.is_at_floor(logs, size);
        let mut free: Vec<usize> = self
            .pairs()
            .iter()
            .filter(awake)
            .flat_map(|&(size, time)| [size, time])
            .collect();
        free.sort_unstable();
        free.dedup();
        free
    }

    /// One step of scoring, shortened until it gains; none that promises less than `least`. Returns what
    /// it gains.
    fn score(&self, at: &mut At, damping: &mut f64, least: f64) -> f64 {
        let free = self.free(&at.logs);
        if free.is_empty() {
            return 0.0;
        }
        let beside = |i: &usize| {
            let mut logs = at.logs;
            logs[*i] += DIFFERENCE;
            if self.of_wheels {
                logs[3] = logs[2];
            }
            self.noise(&logs)
        };
        let all: Vec<Noise> = free.iter().map(beside).collect();
        let moved = (self.samples)(&all);
        let before = at.sample.deviance;
        let gradient =
            DVector::from_fn(free.len(), |i, _| (moved[i].deviance - before) / DIFFERENCE);
        let columns: Vec<Vec<f64>> = moved.iter().map(|own| column(&at.sample, own)).collect();
        let information = DMatrix::from_fn(free.len(), free.len(), |i, k| {
            let pairs = columns[i].iter().zip(&columns[k]);
            2.0 * pairs.map(|(a, b)| a * b).sum::<f64>()
        });
        for _ in 0..=SHORTENED {
            let mut damped = information.clone();
            for i in 0..free.len() {
                damped[(i, i)] += *damping * information[(i, i)] + f64::MIN_POSITIVE.sqrt();
            }
            let Some(factor) = damped.cholesky() else {
                return 0.0;
            };
            let step = factor.solve(&gradient);
            if 0.5 * step.dot(&gradient) < least {
                return 0.0;
            }
            let [up, down] = LONGEST;
            let mut logs = at.logs;
            for (i, step) in free.iter().zip(step.iter()) {
                logs[*i] -= step.clamp(-up, down);
            }
            if self.take(at, logs, 0.0) {
                *damping = (*damping / 10.0).max(1e-6);
                return before - at.sample.deviance;
            }
            *damping *= 10.0;
        }
        0.0
    }
}

/// What the information in a size or time is made of: entries whose products sum to half of that in
/// −2 ln L. Of each row three of the derivative of the innovation and six of that of its covariance,
/// both whitened: ν'ᵀ S⁻¹ ν' and tr(S⁻¹ S' S⁻¹ S') / 2.
fn column(at: &Sample, moved: &Sample) -> Vec<f64> {
    let mut out = Vec::with_capacity(3 * at.whitened.len());
    let per_step = 1.0 / DIFFERENCE;
    for (row, (w, own)) in at.whitening.iter().zip(&moved.whitening).enumerate() {
        let place = 3 * row..3 * row + 3;
        let (e, then) = (&at.whitened[place.clone()], &moved.whitened[place.clone()]);
        let precision = &at.precision[place];
        // dW W⁻¹, which is lower triangular, by substitution from the right
        let mut a = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in (0..=i).rev() {
                let known: f64 = (j + 1..=i).map(|k| a[i][k] * w[k][j]).sum();
                a[i][j] = ((own[i][j] - w[i][j]) * per_step - known) / w[j][j];
            }
        }
        for i in 0..3 {
            let turned: f64 = (0..=i).map(|j| a[i][j] * e[j]).sum();
            let slope = (then[i] - e[i]) * per_step - turned;
            out.push(slope * precision[i].sqrt());
            out.push(std::f64::consts::SQRT_2 * a[i][i]);
        }
        out.extend([a[1][0], a[2][0], a[2][1]]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of three kinds: their variance is that of the surge noise times its time, the same times its
    /// time once more, and that of all other noise, of which there is none.
    fn sample(noise: &Noise) -> Sample {
        let surge = noise.size[0] * noise.size[0] * noise.time_s[0];
        let idle: f64 = noise.size[1..].iter().map(|size| size * size).sum();
        let kinds = [
            (surge, 0.01),
            (surge * noise.time_s[0], 0.0025),
            (idle + 1e-8, 1e-8),
        ];
        let mut sample = Sample::default();
        for (variance, truth) in kinds.repeat(300) {
            let w = f64::sqrt(1.0 / variance);
            sample.deviance += truth / variance + variance.ln();
            sample.whitened.extend([truth.sqrt() * w, 0.0, 0.0]);
            let whitening = [[w, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            sample.whitening.push(whitening);
            sample.precision.extend([1.0; 3]);
        }
        sample
    }

    #[test]
    fn scoring_finds_size_and_time_and_lets_what_is_idle_rest() {
        let search = Search {
            floor: [1e-5; 5],
            of_wheels: false,
            has_pose: true,
            samples: &|all| all.iter().map(sample).collect(),
        };
        let from = Noise {
            size: [0.01, 0.01, 0.01, 0.01, 0.01],
            time_s: [3.0; 3],
            of_wheels: false,
        };
        let (found, _) = search.run(&from, THOROUGH);
        // 0.2² 0.25 = 0.01, and a quarter of it
        assert!((found.size[0] / 0.2).ln().abs() < 0.01, "{found:?}");
        assert!((found.time_s[0] / 0.25).ln().abs() < 0.01, "{found:?}");
        assert!(
            found.size[1..].iter().all(|size| *size < 1.1e-5),
            "{found:?}"
        );
    }
}
