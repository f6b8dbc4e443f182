//! Which effects a recording needs: forward by the best that is lacking, each refitted with its noise;
//! then backward.

use rayon::prelude::*;

use super::fit::{Fit, values};
use super::machine::Machine;
use super::precision::Known;
use super::screen::beside;
use crate::select::criterion::{Criterion, TIE_NATS};
use crate::windows::hypothesis::{Hypothesis, least_probe};

/// Candidates that are refitted with their noise, and of these the ones that are fitted to the end.
const REFITTED: usize = 7;
const POLISHED: usize = 4;
/// Gain at fixed gains (−2 ln L) below which a candidate is not refitted.
const GLANCE_GAIN: f64 = 6.0;
/// Most effects.
const MOST: usize = 5;
/// Share of its smallest probe below which an effect is what integrators differ by.
const TINY: f64 = 0.02;

/// What a recording needs.
pub(crate) struct Selected {
    pub(crate) nominal: Fit,
    pub(crate) fit: Fit,
    /// Of each effect: what it brings (nats).
    pub(crate) gains: Vec<f64>,
    /// Of each effect: those that fit as well in its place.
    pub(crate) alike: Vec<Vec<&'static str>>,
    /// How many effects were tried.
    pub(crate) tried: usize,
}

/// A selection on one machine.
pub(crate) struct Selection<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) all: &'a [Hypothesis],
    pub(crate) progress: &'a (dyn Fn(&str) + Sync),
}

impl Selection<'_> {
    fn tried(&self) -> usize {
        let mut kinds: Vec<&Hypothesis> = Vec::new();
        for hypothesis in self.all {
            if !kinds.iter().any(|known| known.is_like(hypothesis)) {
                kinds.push(hypothesis);
            }
        }
        kinds.len()
    }

    fn criterion(&self, known: Option<&Known>) -> Criterion {
        Criterion {
            tried: self.tried(),
            blocks: known.map_or(2, |known| known.blocks),
        }
    }

    /// −2 ln L that an effect has to bring.
    fn due(&self, hypothesis: &Hypothesis) -> f64 {
        2.0 * self.criterion(None).least_gain(hypothesis.values.len()) + 12.0
    }

    pub(crate) fn run(&self) -> Option<Selected> {
        (self.progress)("nominal model");
        let nominal = self.machine.nominal()?;
        let mut fit = nominal.clone();
        let mut rivals: Vec<(String, Vec<&'static str>)> = Vec::new();
        while fit.hypotheses.len() < MOST {
            let Some((next, near)) = self.extended(&fit) else {
                break;
            };
            let id = next.hypotheses.last()?.info.id.to_owned();
            rivals.push((id, near));
            fit = self.machine.with_best_noise(next);
            fit = self.machine.fitted(fit, 2, 6);
            fit = self.pruned(fit);
            fit = self.swapped(fit, &mut rivals);
        }
        let (gains, alike) = self.weighed(&fit, &rivals);
        Some(Selected {
            nominal,
            fit,
            gains,
            alike,
            tried: self.tried(),
        })
    }

    /// `fit` with the effect that is lacking most, and those that fit as well in its place.
    fn extended(&self, fit: &Fit) -> Option<(Fit, Vec<&'static str>)> {
        let names: Vec<&str> = fit.hypotheses.iter().map(|h| h.info.id).collect();
        (self.progress)(&format!("effects beside [{}]", names.join(", ")));
        let mut candidates = self.machine.screened(fit, self.all);
        candidates.retain(|candidate| candidate.gain > GLANCE_GAIN);
        candidates.truncate(REFITTED);
        let refits: Vec<(f64, Fit)> = candidates
            .par_iter()
            .filter_map(|candidate| {
                let begun = match &candidate.fit {
                    Some(begun) => begun.clone(),
                    None => self
                        .machine
                        .begun(fit, beside(fit, &candidate.hypothesis))?,
                };
                let own = self.refitted(begun, 2, 5);
                Some((self.excess(fit, &own), own))
            })
            .filter(|(excess, own)| *excess > -12.0 && !self.is_tiny(own.hypotheses.last()))
            .collect();
        let best = refits.iter().map(|(excess, _)| *excess).fold(0.0, f64::max);
        let mut leaders: Vec<&(f64, Fit)> = refits
            .iter()
            .filter(|(excess, _)| *excess >= 0.5 * best)
            .collect();
        leaders.sort_by(|a, b| b.0.total_cmp(&a.0));
        leaders.truncate(POLISHED);
        let mut polished: Vec<(f64, Fit)> = leaders
            .par_iter()
            .map(|(_, own)| {
                let own = self.refitted(own.clone(), 6, 8);
                (self.excess(fit, &own), own)
            })
            .filter(|(_, own)| !self.is_tiny(own.hypotheses.last()))
            .collect();
        polished.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (excess, own) in &polished {
            if let Some(h) = own.hypotheses.last() {
                (self.progress)(&format!(
                    "   {} {:?} excess {excess:.1} noise {:?}",
                    h.info.id, h.values, own.noise.size
                ));
            }
        }
        let (excess, best) = polished.first()?;
        if *excess < 0.0 || !self.is_clear(best, best.hypotheses.len() - 1) {
            return None;
        }
        let near = polished[1..]
            .iter()
            .filter(|(other, _)| *other > excess - 2.0 * TIE_NATS)
            .filter_map(|(_, own)| Some(own.hypotheses.last()?.info.id));
        Some((best.clone(), near.collect()))
    }

    /// Fits all parameters and the noise, thresholds by trying others.
    fn refitted(&self, fit: Fit, rounds: usize, iterations: usize) -> Fit {
        self.machine.fitted(fit, rounds, iterations)
    }

    /// What the last effect of `own` brings beyond what is due (−2 ln L).
    fn excess(&self, fit: &Fit, own: &Fit) -> f64 {
        let due = own.hypotheses.last().map_or(0.0, |h| self.due(h));
        fit.deviance - own.deviance - due
    }

    /// Whether an effect is smaller than what integrators differ by.
    fn is_tiny(&self, hypothesis: Option<&Hypothesis>) -> bool {
        hypothesis.is_some_and(|h| {
            !h.is_abrupt()
                && h.values.iter().all(|(name, value)| {
                    let small = least_probe(h.info, name).unwrap_or(0.0);
                    let nothing = h.nothing(&self.machine.model, name);
                    (value - nothing).abs() < TINY * (small - nothing).abs()
                })
        })
    }

    /// Whether the effect at `at` is known to differ from nothing: by the model, and by blocks.
    fn is_clear(&self, fit: &Fit, at: usize) -> bool {
        let hypothesis = &fit.hypotheses[at];
        if hypothesis.is_abrupt() || hypothesis.is_threshold() {
            return true;
        }
        let Some(known) = self.machine.known(fit) else {
            return false;
        };
        let first: usize = fit.hypotheses[..at]
            .iter()
            .map(|h| values(std::slice::from_ref(h)).len())
            .sum();
        let criterion = self.criterion(Some(&known));
        let strength = |covariance: &nalgebra::DMatrix<f64>| {
            hypothesis
                .values
                .iter()
                .enumerate()
                .map(|(i, (name, value))| {
                    let off = value - hypothesis.nothing(&self.machine.model, name);
                    off * off / covariance[(first + i, first + i)]
                })
                .fold(0.0, f64::max)
        };
        (self.progress)(&format!(
            "   clear {} model {:.1} blocks {:.1} over {:.2} least {:.1}",
            hypothesis.info.id,
            strength(&known.model),
            strength(&known.covariance),
            known.overdispersion,
            criterion.alone().least_wald(1)
        ));
        strength(&known.model) > 2.0 * criterion.least_gain(1)
            && strength(&known.covariance) > criterion.alone().least_wald(1)
    }

    fn without(&self, fit: &Fit, at: usize) -> Option<Fit> {
        let mut fewer = fit.hypotheses.clone();
        fewer.remove(at);
        let begun = self.machine.begun(fit, fewer)?;
        Some(self.machine.fitted(begun, 3, 6))
    }

    /// Without the effects that are not worth what is due beside the others.
    fn pruned(&self, mut fit: Fit) -> Fit {
        let mut at = 0;
        while fit.hypotheses.len() > 1 && at < fit.hypotheses.len() {
            if let Some(less) = self.without(&fit, at)
                && less.deviance - fit.deviance < self.due(&fit.hypotheses[at])
            {
                (self.progress)(&format!("   drop {}", fit.hypotheses[at].info.id));
                (fit, at) = (less, 0);
                continue;
            }
            at += 1;
        }
        fit
    }

    /// Each effect against the best in its place.
    fn swapped(&self, mut fit: Fit, rivals: &mut Vec<(String, Vec<&'static str>)>) -> Fit {
        if fit.hypotheses.len() < 2 {
            return fit;
        }
        for id in fit.hypotheses.iter().map(|h| h.info.id).collect::<Vec<_>>() {
            let Some(at) = fit.hypotheses.iter().position(|h| h.info.id == id) else {
                continue;
            };
            let own = fit.hypotheses[at].clone();
            let Some(less) = self.without(&fit, at) else {
                continue;
            };
            let mut candidates = self.machine.screened(&less, self.all);
            candidates.retain(|c| c.gain > GLANCE_GAIN && !c.hypothesis.is_like(&own));
            candidates.truncate(2);
            for candidate in candidates {
                let begun = candidate.fit.or_else(|| {
                    self.machine
                        .begun(&less, beside(&less, &candidate.hypothesis))
                });
                let Some(other) = begun.map(|begun| self.machine.fitted(begun, 2, 6)) else {
                    continue;
                };
                let better = other.deviance + self.due(&candidate.hypothesis)
                    - fit.deviance
                    - self.due(&own);
                if better < -3.0 {
                    (self.progress)(&format!("   swap {id} {}", candidate.hypothesis.info.id));
                    fit = other;
                    break;
                } else if better < 2.0 * TIE_NATS {
                    let rival = candidate.hypothesis.info.id;
                    rivals.push((id.to_owned(), vec![rival]));
                }
            }
        }
        fit
    }

    /// What each effect brings (nats), and its rivals.
    fn weighed(
        &self,
        fit: &Fit,
        rivals: &[(String, Vec<&'static str>)],
    ) -> (Vec<f64>, Vec<Vec<&'static str>>) {
        let each = (0..fit.hypotheses.len()).map(|at| {
            let less = self.without(fit, at);
            let gain = less.map_or(0.0, |less| (less.deviance - fit.deviance) / 2.0);
            let id = fit.hypotheses[at].info.id;
            let own = rivals.iter().filter(|(known, _)| known == id);
            let mut near: Vec<&'static str> = own.flat_map(|(_, near)| near.clone()).collect();
            near.sort_unstable();
            near.dedup();
            near.retain(|rival| !fit.hypotheses.iter().any(|h| h.info.id == *rival));
            (gain, near)
        });
        each.unzip()
    }
}
