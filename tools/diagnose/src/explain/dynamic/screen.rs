//! Which effects a fit lacks, at a glance: each at the gains of the fit, from every start that it has.

use rayon::prelude::*;
use slipstream_sim::effects::Domain;

use super::fit::{Fit, may_slide, values};
use super::machine::Machine;
use crate::model::hypothesis::{Hypothesis, is_limit, kinds, slides};

/// Gain (−2 ln L) at fixed gains below which slip is not looked at with gains of its own.
const SLIP_GAIN: f64 = 6.0;
/// Frictions that are looked at with gains of their own.
const SLIPS: usize = 4;
/// Largest multiple of a probe that is tried: beyond, the flow is not linear.
const MULTIPLE: f64 = 30.0;
/// Smallest and largest play that is tried (rad).
const SMALLEST_RAD: f64 = 0.002;
const LARGEST_RAD: f64 = 0.15;
/// Iterations of a glance.
const GLANCE: usize = 2;

/// An effect that may be lacking.
pub(crate) struct Candidate {
    pub(crate) hypothesis: Hypothesis,
    /// Gain at fixed gains (−2 ln L).
    pub(crate) gain: f64,
    /// Fitted with gains of its own already.
    pub(crate) fit: Option<Fit>,
}

impl Candidate {
    /// A candidate of an earlier look.
    pub(crate) fn earlier(hypothesis: Hypothesis) -> Self {
        Self {
            hypothesis,
            gain: 0.0,
            fit: None,
        }
    }
}

impl Machine {
    /// Candidates among `all` beside `fit`, best first.
    pub(crate) fn screened(&self, fit: &Fit, all: &[Hypothesis]) -> Vec<Candidate> {
        let kinds = kinds(all.iter().filter(|h| !fit.has(h)));
        let each = kinds.par_iter().filter_map(|starts| {
            if slides(starts[0].info) && !may_slide(&self.model, &fit.hypotheses) {
                self.slip(fit, starts)
            } else if starts[0].is_threshold() {
                self.threshold(fit, starts[0])
            } else {
                self.glanced(fit, starts)
            }
        });
        let mut candidates: Vec<Candidate> = each.collect();
        if self.tries("push") {
            candidates.extend(self.push(fit));
        }
        if self.tries("friction_patch") {
            let gains = candidates.iter().map(|candidate| candidate.gain);
            candidates.extend(self.patch(fit, gains.fold(0.0, f64::max)));
        }
        candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        candidates
    }

    /// Slip: at the gains of a model whose noise acts on the wheels, from a small size; then with gains
    /// of its own.
    fn slip(&self, fit: &Fit, starts: &[&Hypothesis]) -> Option<Candidate> {
        let base = self.rolling_with_wheel_noise(fit)?;
        let ranked = |at: &Fit| {
            let gains = starts.par_iter().filter_map(|h| {
                let e = self.promising(at, &beside(fit, h))?;
                let own = self.deviance(&e) + at.log_determinant();
                Some((at.deviance - own, *h))
            });
            let mut ranked: Vec<(f64, &Hypothesis)> =
                gains.filter(|(gain, _)| *gain > SLIP_GAIN).collect();
            ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
            ranked.truncate(SLIPS);
            ranked
        };
        // at small noise what slides is told from what pushes; where nothing else fits, at large
        let mut leaders = ranked(&base);
        if leaders.is_empty() {
            leaders = ranked(fit);
        }
        let fits = leaders.par_iter().filter_map(|(_, h)| {
            let begun = self.begun(fit, beside(fit, h))?;
            Some((fit.deviance - begun.deviance, *h, begun))
        });
        let fits: Vec<(f64, &Hypothesis, Fit)> = fits.collect();
        let best = fits.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Candidate {
            hypothesis: best.1.clone(),
            gain: best.0,
            fit: Some(best.2),
        })
    }

    /// An effect from the best of its starts, by some iterations.
    fn glanced(&self, fit: &Fit, starts: &[&Hypothesis]) -> Option<Candidate> {
        let base = fit.deviance - fit.log_determinant();
        let direct = is_limit(starts[0].info) || starts[0].is_abrupt() || starts[0].has_play();
        let many = starts[0].values.len() > 1;
        let gaps: Vec<Hypothesis> = if starts[0].has_play() {
            gaps(starts[0])
        } else {
            Vec::new()
        };
        let mut best: Option<(f64, Hypothesis)> = None;
        for start in starts.iter().copied().chain(&gaps) {
            let Some(e) = self.promising(fit, &beside(fit, start)) else {
                continue;
            };
            let own = self.deviance(&e);
            let (gain, hypothesis) = if direct || many {
                (base - own, (*start).clone())
            } else {
                self.scaled(fit, start, &e)
            };
            if best.as_ref().is_none_or(|(known, _)| gain > *known) {
                best = Some((gain, hypothesis));
            }
        }
        let (mut gain, mut hypothesis) = best?;
        let with = beside(fit, &hypothesis);
        if let Some(solution) = self.solve(fit, &with, &values(&with), GLANCE) {
            let fitted = super::fit::valued(&with, &solution.at);
            gain = base - solution.deviance;
            hypothesis = fitted.last()?.clone();
        }
        Some(Candidate {
            hypothesis,
            gain,
            fit: None,
        })
    }

    /// A start at the multiple that fits best, were the innovations linear in it; what they gain then.
    fn scaled(&self, fit: &Fit, start: &Hypothesis, e: &[f64]) -> (f64, Hypothesis) {
        let (name, value) = start.values[0];
        let nothing = start.nothing_beside(&self.model, name, &fit.hypotheses);
        let (mut square, mut product) = (0.0, 0.0);
        for (after, before) in e.iter().zip(&fit.whitened) {
            let d = after - before;
            square += d * d;
            product += d * before;
        }
        if square < 1e-12 {
            return (0.0, start.clone());
        }
        let multiple = (-product / square).clamp(-MULTIPLE, MULTIPLE);
        let gain = product * product / square;
        let mut scaled = start.clone();
        let mut held = nothing + multiple * (value - nothing);
        if let Some(Domain::Number { lower, upper, .. }) =
            start.info.parameter(name).map(|p| p.domain)
        {
            held = held.clamp(lower, upper);
            if held == nothing {
                return (0.0, start.clone());
            }
        }
        scaled.set(name, held);
        (gain, scaled)
    }
}

/// The effects of `fit` and one more.
pub(crate) fn beside(fit: &Fit, hypothesis: &Hypothesis) -> Vec<Hypothesis> {
    let mut all = fit.hypotheses.clone();
    all.push(hypothesis.clone());
    all
}

/// Sizes of a play from small to large: what lies between two of them is found from the nearer one.
fn gaps(start: &Hypothesis) -> Vec<Hypothesis> {
    let name = start.values[0].0;
    let sizes = std::iter::successors(Some(SMALLEST_RAD), |size| Some(size * 1.35));
    sizes
        .take_while(|size| *size < LARGEST_RAD)
        .map(|size| {
            let mut own = start.clone();
            own.set(name, size);
            own
        })
        .collect()
}
