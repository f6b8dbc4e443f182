//! Screening of terms that may be lacking: a score test (Rao 1948) beside everything that is fitted already, and what
//! the starts gain from which a search for a term begins.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::chosen::Chosen;
use super::elimination::Elimination;
use crate::estimate::scoring::{Fit, summed};
use crate::estimate::term::{Search, Term};

/// Places at which a profile is looked at before its steps get smaller.
const PLACES: usize = 24;
/// Starts of a candidate that are looked at with derivatives.
const STARTS: usize = 2;
/// Logs by which noise sizes are lowered for a score test: what acts all the time is noise to a model without it,
/// and its score there is small.
pub(super) const LOWERED: [f64; 2] = [0.0, 1.5];
/// The same for everything usual at once.
pub(super) const LOWERED_MORE: [f64; 3] = [0.0, 1.5, 3.0];
/// Steps in which the best start of a single parameter is narrowed.
const HALVINGS: usize = 3;
/// A start that is worse than the fit by more is not followed (nats).
const FOLLOWED_NATS: f64 = 20.0;
/// A score test is exact for small effects alone: candidates that promise this share of what is due are refitted.
const PROMISE: f64 = 0.5;

/// A term that may be lacking, where its fit may begin, and what it promises to gain (nats).
pub(super) struct Candidate<'a> {
    pub(super) term: &'a Term,
    pub(super) starts: Vec<Vec<f64>>,
    promise: f64,
}

/// A place at which a fit of a term may begin: what it gains there, and promises to gain (nats).
pub(super) struct Start {
    pub(super) at: Vec<f64>,
    pub(super) gain: f64,
    promise: f64,
}

impl Elimination<'_> {
    /// Candidates beside `chosen`, the most promising first.
    pub(super) fn screened<'t>(&self, chosen: &Chosen, all: &'t [Term]) -> Vec<Candidate<'t>> {
        let lacking = all
            .iter()
            .filter(|term| !chosen.has(term.name) && term.search != Search::Located);
        let lacking: Vec<&Term> = lacking.collect();
        let scores: Vec<LackingScores> = LOWERED
            .par_iter()
            .filter_map(|lowered| self.scores(&chosen.fit, &lacking, *lowered))
            .collect();
        // from the noise that was fitted, and from less: what acts all the time was noise so far
        let less = self.with_noise(&chosen.fit.at, -LOWERED[1]);
        let candidates = lacking.par_iter().filter_map(|term| {
            let smooth = scores.iter().filter(|_| term.is_smooth());
            let promises = smooth.map(|own| own.promise(term));
            let less = self.effort.from_less.then(|| less.clone());
            let mut own = Candidate {
                term,
                starts: std::iter::once(chosen.fit.at.clone()).chain(less).collect(),
                promise: promises.fold(0.0, f64::max),
            };
            // what a start gains is certain, what a score promises far from it is not
            let starts = self.starts(&chosen.fit, term).into_iter();
            if let Some(start) = starts.max_by(|a, b| a.promise.total_cmp(&b.promise)) {
                own.promise = own.promise.max(start.promise);
                own.starts[0] = start.at;
            }
            (own.promise > PROMISE * self.due(term)).then_some(own)
        });
        let mut candidates: Vec<Candidate<'t>> = candidates.collect();
        candidates.sort_by(|a, b| {
            let [a, b] = [a, b].map(|own| own.promise - self.due(own.term));
            b.total_cmp(&a)
        });
        let best = candidates.first().map_or(0.0, |own| own.promise);
        candidates.retain(|own| own.promise >= self.effort.least_promise * best);
        candidates
    }

    /// Candidates beside `chosen` that act at a time or a place; `rival` is the best fit with another one.
    pub(super) fn located<'t>(
        &self,
        chosen: &Chosen,
        rival: &Fit,
        all: &'t [Term],
    ) -> Vec<Candidate<'t>> {
        let located = all
            .iter()
            .filter(|term| term.search == Search::Located && !chosen.has(term.name));
        let of = |term: &'t Term| Candidate {
            term,
            starts: self
                .problem
                .likelihood
                .located(term, &chosen.fit.at, &rival.at),
            promise: 0.0,
        };
        located
            .map(of)
            .filter(|own| !own.starts.is_empty())
            .collect()
    }

    /// Places at which a fit of a term may begin, and what they promise (nats).
    pub(super) fn starts(&self, fit: &Fit, term: &Term) -> Vec<Start> {
        let near = self.problem.likelihood.near(&fit.at);
        let start = |values: &[f64]| {
            let mut at = fit.at.clone();
            for (index, value) in term.parameters.iter().zip(values) {
                at[*index] = *value;
            }
            let own = term.parameters.iter();
            let prior: f64 = own.map(|i| self.problem.priors[*i].log(at[*i])).sum();
            let own: f64 = near(&at).iter().sum();
            let gain = own + self.problem.log_prior(&at, &fit.free) + prior - fit.objective;
            Start {
                at,
                gain,
                promise: gain,
            }
        };
        match &term.search {
            Search::Located => Vec::new(),
            Search::Profiled(values) => profiled(values, &|value| start(&[value])),
            Search::Smooth(starts) => {
                let mut all: Vec<Start> = starts.iter().map(|own| start(own)).collect();
                if let [index] = term.parameters[..] {
                    let near = all.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
                    let near = near
                        .map(|own| narrowed((own.at[index], own.gain), starts, &|x| start(&[x])));
                    all.extend(near.into_iter().flatten());
                }
                all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
                all.truncate(STARTS);
                all.retain(|own| own.gain > -FOLLOWED_NATS);
                for own in &mut all {
                    own.promise += self.newton(&own.at, term);
                }
                all
            }
        }
    }

    /// What one Newton step of a term's own parameters promises (nats).
    fn newton(&self, at: &[f64], term: &Term) -> f64 {
        let own = &term.parameters;
        let scores = self.problem.likelihood.score(at, own);
        let (gradient, mut information) = summed(&scores, own.len());
        self.problem.add_priors(&mut information, at, own);
        promised(information, &gradient)
    }

    /// What `added` parameters promise beside all others of `free` (nats), at the noise of `at` and at less.
    pub(crate) fn promise(&self, at: &[f64], free: &[usize], added: &[usize]) -> f64 {
        let known = self.problem.objective(at, free);
        let kept: Vec<usize> = (0..free.len())
            .filter(|i| !added.contains(&free[*i]))
            .collect();
        let promises = LOWERED.par_iter().map(|lowered| {
            let at = self.with_noise(at, -lowered);
            let scores = self.problem.likelihood.score(&at, free);
            let (gradient, information) = self.problem.total(&scores, &at, free);
            let of_kept = information.select_rows(&kept).select_columns(&kept);
            let fitted = promised(of_kept, &gradient.select_rows(&kept));
            let own = promised(information, &gradient);
            own - fitted - (known - self.problem.objective(&at, free))
        });
        promises.reduce(|| 0.0, f64::max)
    }

    /// Scores of everything that is fitted and that is lacking, with noise sizes lowered by so much.
    fn scores(&self, fit: &Fit, lacking: &[&Term], lowered: f64) -> Option<LackingScores> {
        let at = self.with_noise(&fit.at, -lowered);
        let lost = fit.objective - self.problem.objective(&at, &fit.free);
        let mut indices = fit.free.clone();
        let smooth = lacking.iter().filter(|term| term.is_smooth());
        for index in smooth.flat_map(|term| &term.parameters) {
            if !indices.contains(index) {
                indices.push(*index);
            }
        }
        let scores = self.problem.likelihood.score(&at, &indices);
        let (gradient, mut all) = summed(&scores, indices.len());
        self.problem.add_priors(&mut all, &at, &fit.free);
        let count = fit.free.len();
        let fitted = all.view((0, 0), (count, count)).into_owned();
        let factor = fitted.cholesky()?;
        let beside = all.columns(count, indices.len() - count);
        let across = beside.rows(0, count).into_owned();
        let own = beside.rows(count, indices.len() - count).into_owned();
        let mut information = own - across.transpose() * factor.solve(&across);
        self.problem
            .add_priors(&mut information, &at, &indices[count..]);
        Some(LackingScores {
            lost,
            information,
            gradient: gradient.rows(count, indices.len() - count).into_owned(),
            indices: indices.split_off(count),
        })
    }
}

/// What a Newton step gains where a likelihood is quadratic (nats).
fn promised(information: DMatrix<f64>, gradient: &DVector<f64>) -> f64 {
    let step = information.cholesky().map(|own| own.solve(gradient));
    step.map_or(0.0, |step| 0.5 * gradient.dot(&step))
}

/// Values around the best of `starts`, in ever smaller steps towards the best of them.
fn narrowed(best: (f64, f64), starts: &[Vec<f64>], of: &dyn Fn(f64) -> Start) -> Vec<Start> {
    let others = starts.iter().map(|own| own[0]).chain([0.0]);
    let apart = others.map(|own| (own - best.0).abs());
    let apart = apart.filter(|own| *own > 0.0);
    let mut step = 0.5 * apart.fold(f64::INFINITY, f64::min);
    let mut centre = best;
    let mut all = Vec::new();
    for _ in 0..HALVINGS {
        for value in [centre.0 - step, centre.0 + step] {
            let own = of(value);
            if own.gain > centre.1 {
                centre = (value, own.gain);
            }
            all.push(own);
        }
        step *= 0.5;
    }
    all
}

/// The best of rising values, looked for in ever smaller steps.
fn profiled(values: &[f64], of: &dyn Fn(f64) -> Start) -> Vec<Start> {
    let mut range = 0..values.len();
    let mut best: Option<(usize, Start)> = None;
    while !range.is_empty() {
        let stride = range.len().div_ceil(PLACES);
        for place in range.clone().step_by(stride) {
            let own = of(values[place]);
            if best.as_ref().is_none_or(|(_, known)| own.gain > known.gain) {
                best = Some((place, own));
            }
        }
        let Some((place, _)) = &best else { break };
        if stride == 1 {
            break;
        }
        range = place.saturating_sub(stride)..(place + stride).min(values.len());
    }
    best.map(|(_, own)| own).into_iter().collect()
}

/// Score and information of what is lacking, beside what is fitted.
struct LackingScores {
    /// By how much the fit is worse with lowered noise (nats).
    lost: f64,
    indices: Vec<usize>,
    gradient: DVector<f64>,
    information: DMatrix<f64>,
}

impl LackingScores {
    /// What a term would gain were the likelihood quadratic (nats).
    fn promise(&self, term: &Term) -> f64 {
        let places = term.parameters.iter();
        let places = places.filter_map(|index| self.indices.iter().position(|own| own == index));
        let places: Vec<usize> = places.collect();
        let count = places.len();
        let gradient = DVector::from_fn(count, |i, _| self.gradient[places[i]]);
        let information = DMatrix::from_fn(count, count, |i, k| {
            self.information[(places[i], places[k])]
        });
        let step = information.cholesky().map(|factor| factor.solve(&gradient));
        step.map_or(0.0, |step| 0.5 * gradient.dot(&step) - self.lost)
    }
}
