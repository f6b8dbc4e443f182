//! Which causes explain the printed numbers, each charged for.
//!
//! Squares of what is left, over the tape's accuracy, and a charge for every cause: ln n for its size (Schwarz 1978), and
//! twice the logarithm of the number of kinds and places that it was chosen among. The responses are added up; the caller
//! checks the result by simulation.

use nalgebra::{DMatrix, DVector};

use super::numbers::{COUNT, Numbers};
use super::simulated::Response;

/// Accuracy of the tape and of printing (m): the last digit that the paper prints of what was measured.
pub(super) const TAPE_M: f64 = 0.01;
/// Most steps of a fit.
const STEPS: usize = 30;
/// Most exchanges and drops of causes after one was added.
const CHANGES: usize = 10;
/// Least gain of a change.
const LEAST_GAIN: f64 = 1e-3;

/// The causes and their sizes: places in the list of responses.
pub(super) type Chosen = Vec<(usize, f64)>;

/// Numbers to be explained, by responses.
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem<'a> {
    pub(super) responses: &'a [Response],
    pub(super) nominal: &'a Numbers,
    pub(super) printed: &'a Numbers,
    /// Which numbers are known; the others are held out.
    pub(super) known: [bool; COUNT],
}

impl Problem<'_> {
    /// Number of known numbers.
    fn count(&self) -> usize {
        self.known.iter().filter(|own| **own).count()
    }

    /// What causes cost.
    fn charge(&self, chosen: &Chosen) -> f64 {
        let size = (self.count() as f64).ln();
        let own = |&(place, _): &(usize, f64)| {
            size + 2.0 * self.responses[place].candidate.choices().ln()
        };
        chosen.iter().map(own).sum()
    }

    /// What decides between sets of causes; less is better.
    fn score(&self, chosen: &Chosen) -> f64 {
        self.misfit(chosen) + self.charge(chosen)
    }

    /// The numbers with these causes (m).
    pub(super) fn numbers(&self, chosen: &Chosen) -> Numbers {
        let mut numbers = *self.nominal;
        for &(place, size) in chosen {
            let change = self.responses[place].at(size);
            for (number, change) in numbers.iter_mut().zip(change) {
                *number += change;
            }
        }
        numbers
    }

    /// What is left of the known numbers, over the tape's accuracy; 0 for those held out.
    fn left(&self, chosen: &Chosen) -> DVector<f64> {
        let numbers = self.numbers(chosen);
        DVector::from_fn(COUNT, |i, _| match self.known[i] {
            true => (self.printed[i] - numbers[i]) / TAPE_M,
            false => 0.0,
        })
    }

    /// Sum of the squares of what is left.
    pub(super) fn misfit(&self, chosen: &Chosen) -> f64 {
        self.left(chosen).norm_squared()
    }

    /// How the numbers change with the size of each cause, over the tape's accuracy.
    fn slopes(&self, chosen: &Chosen) -> DMatrix<f64> {
        DMatrix::from_fn(COUNT, chosen.len(), |i, column| {
            let (place, size) = chosen[column];
            let response = &self.responses[place];
            let step = 0.02 * response.candidate.kind.largest();
            let [low, high] = [size - step, size + step].map(|size| response.at(size)[i]);
            match self.known[i] {
                true => (high - low) / (2.0 * step) / TAPE_M,
                false => 0.0,
            }
        })
    }

    /// The sizes that leave the least, from these on.
    pub(super) fn fitted(&self, mut chosen: Chosen) -> Chosen {
        let mut misfit = self.misfit(&chosen);
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let next = step(
                &chosen,
                &self.slopes(&chosen),
                &self.left(&chosen),
                damping,
                |place| self.responses[place].candidate.kind.largest(),
            );
            let Some(next) = next else {
                break;
            };
            let reached = self.misfit(&next);
            if reached < misfit {
                let gain = misfit - reached;
                (chosen, misfit, damping) = (next, reached, damping / 4.0);
                if gain < 1e-6 {
                    break;
                }
            } else {
                damping *= 8.0;
            }
        }
        chosen
    }

    /// With one cause more: from its best simulated size on.
    fn with(&self, chosen: &Chosen, place: usize) -> Chosen {
        let started = self.responses[place].sizes().map(|size| {
            let mut own = chosen.clone();
            own.push((place, size));
            own
        });
        let best = started.min_by(|a, b| self.misfit(a).total_cmp(&self.misfit(b)));
        self.fitted(best.unwrap_or_else(|| chosen.clone()))
    }

    /// Without one cause.
    pub(super) fn without(&self, chosen: &Chosen, index: usize) -> Chosen {
        let mut own = chosen.clone();
        own.remove(index);
        self.fitted(own)
    }

    /// The best of some sets of causes, if it is better than `chosen`.
    fn better(&self, chosen: &Chosen, others: impl Iterator<Item = Chosen>) -> Option<Chosen> {
        let scored = others.map(|own| (self.score(&own), own));
        let best = scored.min_by(|a, b| a.0.total_cmp(&b.0));
        let (score, own) = best?;
        (score < self.score(chosen) - LEAST_GAIN).then_some(own)
    }

    /// The causes that are not among these.
    fn others(&self, chosen: &Chosen) -> impl Iterator<Item = usize> {
        let is_other = |place: &usize| chosen.iter().all(|(own, _)| own != place);
        (0..self.responses.len()).filter(is_other)
    }

    /// The causes that explain the known numbers: one at a time is added, exchanged or dropped while that is better.
    pub(super) fn chosen(&self) -> Chosen {
        let mut chosen = Chosen::new();
        loop {
            let added = self.others(&chosen).map(|place| self.with(&chosen, place));
            let fits = |own: &Chosen| own.len() * 2 <= self.count();
            let Some(next) = self.better(&chosen, added.filter(fits)) else {
                return chosen;
            };
            chosen = self.settled(next);
        }
    }

    /// With causes exchanged and dropped while that is better.
    fn settled(&self, mut chosen: Chosen) -> Chosen {
        for _ in 0..CHANGES {
            let changed = (0..chosen.len()).flat_map(|index| {
                let rest = self.without(&chosen, index);
                let exchanged: Vec<Chosen> = self
                    .others(&chosen)
                    .map(|place| self.with(&rest, place))
                    .collect();
                std::iter::once(rest).chain(exchanged)
            });
            match self.better(&chosen, changed) {
                Some(next) => chosen = next,
                None => break,
            }
        }
        chosen
    }

    /// The other causes that explain as much in the place of one, the best first: those that leave at most `slack` more.
    pub(super) fn rivals(&self, chosen: &Chosen, index: usize, slack: f64) -> Vec<(usize, f64)> {
        let most = self.misfit(chosen) + slack;
        let rest = self.without(chosen, index);
        // The same thing acting elsewhere too, where the size of another cause makes up for it, is no other explanation.
        let kind = |place: usize| self.responses[place].candidate.kind;
        let is_another = |place: &usize| rest.iter().all(|(own, _)| kind(*own) != kind(*place));
        let tried = self.others(chosen).filter(is_another).filter_map(|place| {
            let own = self.with(&rest, place);
            let misfit = self.misfit(&own);
            (misfit < most).then_some((misfit, *own.last()?))
        });
        let mut rivals: Vec<(f64, (usize, f64))> = tried.collect();
        rivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        rivals.into_iter().map(|(_, rival)| rival).collect()
    }
}

/// A step of Levenberg and Marquardt: sizes scaled by the largest, and kept within it. `None` if there is none.
pub(super) fn step(
    chosen: &Chosen,
    slopes: &DMatrix<f64>,
    left: &DVector<f64>,
    damping: f64,
    largest: impl Fn(usize) -> f64,
) -> Option<Chosen> {
    let scales = DVector::from_iterator(chosen.len(), chosen.iter().map(|own| largest(own.0)));
    let scaled = slopes * DMatrix::from_diagonal(&scales);
    let mut normal = scaled.transpose() * &scaled;
    for i in 0..chosen.len() {
        normal[(i, i)] = normal[(i, i)] * (1.0 + damping) + 1e-9;
    }
    let change = normal.cholesky()?.solve(&(scaled.transpose() * left));
    let next = chosen.iter().enumerate().map(|(i, &(place, size))| {
        let largest = scales[i];
        (place, (size + change[i] * largest).clamp(-largest, largest))
    });
    Some(next.collect())
}

/// Half the width of the 95 % interval of each size, widened by what is left beyond the tape's accuracy.
pub(super) fn half_widths(slopes: &DMatrix<f64>, left: &DVector<f64>) -> Option<Vec<f64>> {
    let covariance = (slopes.transpose() * slopes).try_inverse()?;
    let free = (slopes.nrows().saturating_sub(slopes.ncols())).max(1) as f64;
    let widened = (left.norm_squared() / free).max(1.0).sqrt();
    let half = |i: usize| 1.96 * covariance[(i, i)].max(0.0).sqrt() * widened;
    Some((0..slopes.ncols()).map(half).collect())
}
