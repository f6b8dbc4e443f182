//! Forward selection: the term that is lacking most is added, as long as one brings what is due; then each
//! term is tried against its look-alikes in its place.
//!
//! Candidates are screened by a score test (Rao 1948) beside everything that is fitted already, and at the starts
//! from which a search for them begins; the best few are refitted with all noise sizes.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::criterion::TIE_NATS;
use super::elimination::Elimination;
use crate::estimate::BlockScore;
use crate::estimate::scoring::{FULL, Fit, SHORT, SearchLimits};
use crate::estimate::term::{Search, Term};

/// Candidates that are refitted with noise sizes, and of these the ones that are fitted to the end.
const REFITTED: usize = 6;
const POLISHED: usize = 3;
/// A fit that tells which of them are the best.
const RANKED: SearchLimits = SearchLimits {
    iterations: 3,
    tolerance_nats: 1.0,
};
/// Places at which a profile is looked at before its steps get smaller.
const PLACES: usize = 24;
/// Starts of a candidate that are looked at with derivatives.
const STARTS: usize = 2;
/// Logs by which noise sizes are lowered for a score test: what acts all the time is noise to a model without it,
/// and its score there is small.
const LOWERED: [f64; 2] = [0.0, 1.5];
/// The same for everything usual at once.
const LOWERED_MORE: [f64; 3] = [0.0, 1.5, 3.0];
/// Steps in which the best start of a single parameter is narrowed.
const HALVINGS: usize = 3;
/// A start that is worse than the fit by more is not followed (nats).
const FOLLOWED_NATS: f64 = 20.0;
/// A score test is exact for small effects alone: candidates that promise this share of what is due are refitted.
const PROMISE: f64 = 0.5;
/// A term is tried in the place of another from which it would take over this share.
const LOOK_ALIKE: f64 = 0.25;
/// A short fit that is worse by more is not finished (nats).
const UNFINISHED_NATS: f64 = 15.0;
/// A look-alike has to fit better by this to take a term's place (nats).
const BETTER_NATS: f64 = 1.0;
/// A term may be needless that would cost less than so many times what is due, were the likelihood quadratic.
const IDLE: f64 = 2.0;
/// Most exchanges of one selection.
const EXCHANGES: usize = 6;

/// A term that may be lacking, where its fit may begin, and what it promises to gain (nats).
struct Candidate<'a> {
    term: &'a Term,
    starts: [Vec<f64>; 2],
    promise: f64,
}

/// A place at which a fit of a term may begin: what it gains there, and promises to gain (nats).
struct Start {
    at: Vec<f64>,
    gain: f64,
    promise: f64,
}

/// A set of terms and its fit.
#[derive(Debug, Clone)]
pub(crate) struct Chosen {
    pub(crate) fit: Fit,
    pub(crate) terms: Vec<Term>,
    /// Terms that were chosen, each with one that fits as well in its place.
    pub(crate) alike: Vec<[&'static str; 2]>,
}

impl Chosen {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.terms.iter().any(|term| term.name == name)
    }
}

impl Elimination<'_> {
    /// Adds to `chosen` what is lacking of `all`, the most first.
    pub(crate) fn forward(&self, mut chosen: Chosen, all: &[Term], hear: &dyn Fn(&str)) -> Chosen {
        while let Some(next) = self.extended(&chosen, all) {
            let next = self.lightened(next, all);
            if self.worth(&next) < self.worth(&chosen) + BETTER_NATS {
                break;
            }
            for term in next.terms.iter().filter(|term| !chosen.has(term.name)) {
                hear(term.name);
            }
            chosen = next;
        }
        chosen
    }

    /// The better of what is selected from `begun` on, and from everything usual: terms that lower the noise only
    /// together are not found one by one.
    pub(crate) fn forward_from_both(
        &self,
        begun: Chosen,
        all: &[Term],
        hear: &dyn Fn(&str),
    ) -> Chosen {
        let usual = self.with_usual(&begun, all);
        let both = [self.lightened(usual, all), begun];
        let both = both.map(|own| self.forward(own, all, hear));
        let [usual, other] = both;
        if self.worth(&usual) > self.worth(&other) {
            usual
        } else {
            other
        }
    }

    /// A fit with all usual terms: the best of several.
    fn with_usual(&self, begun: &Chosen, all: &[Term]) -> Chosen {
        let usual = all.iter().filter(|term| term.usual);
        let terms: Vec<Term> = usual.cloned().collect();
        let mut at = begun.fit.at.clone();
        for term in &terms {
            let starts = self.starts(&begun.fit, term).into_iter();
            let best = starts.max_by(|a, b| a.gain.total_cmp(&b.gain));
            if let Some(own) = best.filter(|own| own.gain > 0.0) {
                for index in &term.parameters {
                    at[*index] = own.at[*index];
                }
            }
        }
        let (free, _) = self.free(&terms);
        let fits = LOWERED_MORE.par_iter().map(|lowered| {
            let mut at = at.clone();
            for index in self.noise {
                at[*index] -= lowered;
            }
            self.problem.fit(&at, &free, FULL)
        });
        let fits: Vec<Fit> = fits.collect();
        let best = fits
            .into_iter()
            .max_by(|a, b| a.objective.total_cmp(&b.objective));
        Chosen {
            fit: best.unwrap_or_else(|| begun.fit.clone()),
            terms,
            alike: Vec::new(),
        }
    }

    fn extended(&self, chosen: &Chosen, all: &[Term]) -> Option<Chosen> {
        let candidates = self.screened(chosen, all);
        let best = self.best(chosen, &candidates);
        best.filter(|own| self.worth(own) > self.worth(chosen))
    }

    /// What the last term brings beyond what is due.
    fn excess(&self, fit: &Fit, own: &Chosen) -> f64 {
        let due = own.terms.last().map_or(0.0, |term| self.due(term));
        own.fit.objective - fit.objective - due
    }

    /// Refits the first candidates beside `chosen`; the one that brings most beyond what is due.
    fn best(&self, chosen: &Chosen, candidates: &[Candidate<'_>]) -> Option<Chosen> {
        let with = |term: &Term, start: &[f64], limits| {
            let mut terms = chosen.terms.clone();
            terms.push(term.clone());
            Chosen {
                fit: self.fit_near(start, &terms, term, limits),
                terms,
                alike: chosen.alike.clone(),
            }
        };
        let first = candidates.par_iter().take(REFITTED).flat_map(|own| {
            let starts = own.starts.par_iter();
            starts.map(|start| (own.term, start))
        });
        let short = first.map(|(term, start)| with(term, start, RANKED));
        let mut short: Vec<Chosen> = short.collect();
        short.sort_by(|a, b| {
            let [a, b] = [a, b].map(|own| self.excess(&chosen.fit, own));
            b.total_cmp(&a)
        });
        // of one term the better start alone
        let mut seen: Vec<&str> = Vec::new();
        short.retain(|own| {
            let name = own.terms.last().map_or("", |term| term.name);
            let is_new = !seen.contains(&name);
            seen.push(name);
            is_new
        });
        let polished = short.par_iter().take(POLISHED).filter_map(|own| {
            let own = with(own.terms.last()?, &own.fit.at, FULL);
            self.is_possible(own.terms.last()?, &own.fit).then_some(own)
        });
        let polished: Vec<Chosen> = polished.collect();
        polished.into_iter().max_by(|a, b| {
            let [a, b] = [a, b].map(|own| self.excess(&chosen.fit, own));
            a.total_cmp(&b)
        })
    }

    /// Candidates beside `chosen`, the most promising first.
    fn screened<'t>(&self, chosen: &Chosen, all: &'t [Term]) -> Vec<Candidate<'t>> {
        let lacking = all.iter().filter(|term| !chosen.has(term.name));
        let lacking: Vec<&Term> = lacking.collect();
        let scores: Vec<Scores> = LOWERED
            .par_iter()
            .filter_map(|lowered| self.scores(&chosen.fit, &lacking, *lowered))
            .collect();
        let candidates = lacking.par_iter().filter_map(|term| {
            let smooth = scores.iter().filter(|_| !term.is_profiled());
            let promises = smooth.map(|own| own.promise(term));
            // from the noise that was fitted, and from less: what acts all the time was noise so far
            let mut less = chosen.fit.at.clone();
            for index in self.noise {
                less[*index] -= LOWERED[1];
            }
            let mut own = Candidate {
                term,
                starts: [chosen.fit.at.clone(), less],
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
        candidates
    }

    /// Places at which a fit of a term may begin, and what they promise (nats).
    fn starts(&self, fit: &Fit, term: &Term) -> Vec<Start> {
        let start = |values: &[f64]| {
            let mut at = fit.at.clone();
            for (index, value) in term.parameters.iter().zip(values) {
                at[*index] = *value;
            }
            let own = term.parameters.iter();
            let prior: f64 = own.map(|i| self.problem.priors[*i].log(at[*i])).sum();
            let gain = self.problem.objective(&at, &fit.free) + prior - fit.objective;
            Start {
                at,
                gain,
                promise: gain,
            }
        };
        match &term.search {
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
        let mut own = Sums::new(&self.problem.likelihood.score(at, &term.parameters));
        for (place, index) in term.parameters.iter().enumerate() {
            own.information[(place, place)] += self.problem.priors[*index].precision();
        }
        let step = own.information.cholesky().map(|c| c.solve(&own.gradient));
        step.map_or(0.0, |step| 0.5 * own.gradient.dot(&step))
    }

    /// What `added` parameters promise beside all others of `free` (nats), at the noise of `at` and at less.
    pub(crate) fn promise(&self, at: &[f64], free: &[usize], added: &[usize]) -> f64 {
        let known = self.problem.objective(at, free);
        let kept: Vec<usize> = (0..free.len())
            .filter(|i| !added.contains(&free[*i]))
            .collect();
        let promises = LOWERED.par_iter().map(|lowered| {
            let mut at = at.to_vec();
            for index in self.noise {
                at[*index] -= lowered;
            }
            let scores = self.problem.likelihood.score(&at, free);
            let (gradient, information) = self.problem.total(&scores, &at, free);
            let [fitted, own] = [
                (
                    information.select_rows(&kept).select_columns(&kept),
                    gradient.select_rows(&kept),
                ),
                (information, gradient),
            ];
            let gain = |(information, gradient): (DMatrix<f64>, DVector<f64>)| {
                let step = information.cholesky().map(|own| own.solve(&gradient));
                step.map_or(0.0, |step| 0.5 * gradient.dot(&step))
            };
            gain(own) - gain(fitted) - (known - self.problem.objective(&at, free))
        });
        promises.reduce(|| 0.0, f64::max)
    }

    /// Scores of everything that is fitted and that is lacking, with noise sizes lowered by so much.
    fn scores(&self, fit: &Fit, lacking: &[&Term], lowered: f64) -> Option<Scores> {
        let mut at = fit.at.clone();
        for index in self.noise {
            at[*index] -= lowered;
        }
        let lost = fit.objective - self.problem.objective(&at, &fit.free);
        let mut indices = fit.free.clone();
        let smooth = lacking.iter().filter(|term| !term.is_profiled());
        for index in smooth.flat_map(|term| &term.parameters) {
            if !indices.contains(index) {
                indices.push(*index);
            }
        }
        let scores = self.problem.likelihood.score(&at, &indices);
        let mut sums = Sums::new(&scores);
        for (place, index) in fit.free.iter().enumerate() {
            sums.information[(place, place)] += self.problem.priors[*index].precision();
        }
        let count = fit.free.len();
        let fitted = sums.information.view((0, 0), (count, count)).into_owned();
        let factor = fitted.cholesky()?;
        let beside = sums.information.columns(count, indices.len() - count);
        let across = beside.rows(0, count).into_owned();
        let own = beside.rows(count, indices.len() - count).into_owned();
        let mut information = own - across.transpose() * factor.solve(&across);
        for (place, index) in indices[count..].iter().enumerate() {
            information[(place, place)] += self.problem.priors[*index].precision();
        }
        Some(Scores {
            lost,
            information,
            gradient: sums
                .gradient
                .rows(count, indices.len() - count)
                .into_owned(),
            indices: indices.split_off(count),
        })
    }

    /// Each term against the best in its place.
    pub(crate) fn exchanged(&self, mut chosen: Chosen, all: &[Term]) -> Chosen {
        for _ in 0..EXCHANGES {
            if all.is_empty() {
                break;
            }
            match self.exchange(&mut chosen, all) {
                Some(better) => chosen = better,
                None => break,
            }
        }
        chosen
    }

    /// What a set is worth: its fit without what is due for its terms.
    fn worth(&self, own: &Chosen) -> f64 {
        own.fit.objective - own.terms.iter().map(|term| self.due(term)).sum::<f64>()
    }

    /// The same without terms that others make needless.
    fn lightened(&self, mut chosen: Chosen, all: &[Term]) -> Chosen {
        let mut tried: Vec<&str> = Vec::new();
        while let Some(gone) = self.idle_term(&chosen, &tried) {
            tried.push(gone.name);
            let (fit, terms, _) = self.removed(&chosen.fit, &gone, &chosen.terms, all);
            let less = Chosen {
                fit,
                terms,
                alike: Vec::new(),
            };
            if self.worth(&less) > self.worth(&chosen) {
                chosen = less;
            }
        }
        chosen
    }

    /// The term that would cost least, were the likelihood quadratic, where that is little; `tried` are not asked.
    fn idle_term(&self, chosen: &Chosen, tried: &[&str]) -> Option<Term> {
        let fit = &chosen.fit;
        let asked = chosen.terms.iter().filter(|term| {
            !term.is_nuisance() && !term.is_profiled() && !tried.contains(&term.name)
        });
        let asked: Vec<&Term> = asked.collect();
        if asked.is_empty() {
            return None;
        }
        let scores = self.problem.likelihood.score(&fit.at, &fit.free);
        let (_, information) = self.problem.total(&scores, &fit.at, &fit.free);
        let covariance = information.cholesky()?.inverse();
        let loss = |term: &Term| {
            let places = term.parameters.iter();
            let places = places.filter_map(|index| fit.free.iter().position(|f| f == index));
            let places: Vec<usize> = places.collect();
            let count = places.len();
            let own = DMatrix::from_fn(count, count, |i, k| covariance[(places[i], places[k])]);
            let size = DVector::from_fn(count, |i, _| fit.at[term.parameters[i]]);
            let own = own.cholesky();
            own.map_or(0.0, |own| 0.5 * size.dot(&own.solve(&size))) / self.due(term)
        };
        let all = asked.into_iter().map(|term| (loss(term), term));
        let least = all.min_by(|a, b| a.0.total_cmp(&b.0));
        least
            .filter(|(share, _)| *share < IDLE)
            .map(|(_, term)| term.clone())
    }

    /// A better set with one term in the place of another; ties are kept in `chosen`.
    fn exchange(&self, chosen: &mut Chosen, all: &[Term]) -> Option<Chosen> {
        chosen.alike.clear();
        let lacking = all
            .iter()
            .filter(|term| !chosen.has(term.name) && !term.is_nuisance());
        let lacking: Vec<&Term> = lacking.filter(|term| !term.is_profiled()).collect();
        let overlap = self.overlap(&chosen.fit, &lacking);
        let own = chosen.terms.iter();
        let own: Vec<Term> = own
            .filter(|t| !t.is_nuisance() && !t.is_profiled())
            .cloned()
            .collect();
        let mut trials: Vec<(f64, &Term, &Term, Vec<f64>)> = Vec::new();
        for gone in &own {
            for other in &lacking {
                let found = overlap.in_place_of(&chosen.fit, gone, other);
                trials.extend(found.map(|(share, start)| (share, gone, *other, start)));
            }
        }
        trials.retain(|(share, ..)| *share > LOOK_ALIKE);
        trials.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, gone, other, mut start) in trials {
            self.problem.likelihood.loosen(&mut start);
            let mut terms = chosen.terms.clone();
            terms.retain(|term| term.name != gone.name);
            terms.push(other.clone());
            let both = Term {
                parameters: [gone.parameters.as_slice(), &other.parameters].concat(),
                ..other.clone()
            };
            let with = |start: &[f64], limits| Chosen {
                fit: self.fit_near(start, &terms, &both, limits),
                terms: terms.clone(),
                alike: Vec::new(),
            };
            let mut with = with(&start, SHORT);
            if self.worth(&with) < self.worth(chosen) - UNFINISHED_NATS {
                continue;
            }
            with.fit = self.fit_near(&with.fit.at, &terms, &both, FULL);
            if !self.is_possible(other, &with.fit) {
                continue;
            }
            let with = self.lightened(with, all);
            let better = self.worth(&with) - self.worth(chosen);
            if better > BETTER_NATS {
                return Some(with);
            }
            if better > -TIE_NATS {
                chosen.alike.push([gone.name, other.name]);
            }
        }
        None
    }

    /// The information on everything that is fitted and that is lacking. Where a threshold or a lag is 0, what
    /// it would do begins at its first start.
    fn overlap(&self, fit: &Fit, lacking: &[&Term]) -> Overlap {
        let mut at = fit.at.clone();
        let mut indices = fit.free.clone();
        for term in lacking {
            if let Search::Smooth(starts) = &term.search
                && let ([index], Some(first)) = (term.parameters.as_slice(), starts.first())
                && (term.positive || term.name == "lag")
            {
                at[*index] = first[0];
            }
            let new = term
                .parameters
                .iter()
                .filter(|index| !fit.free.contains(index));
            indices.extend(new.copied().collect::<Vec<_>>());
        }
        indices.sort_unstable();
        indices.dedup();
        let mut sums = Sums::new(&self.problem.likelihood.score(&at, &indices));
        for (place, index) in indices.iter().enumerate() {
            sums.information[(place, place)] += self.problem.priors[*index].precision();
        }
        Overlap {
            at,
            indices,
            information: sums.information,
        }
    }
}

/// The information on everything that is fitted and that is lacking.
struct Overlap {
    at: Vec<f64>,
    indices: Vec<usize>,
    information: DMatrix<f64>,
}

impl Overlap {
    /// What of a term another one would take over in its place, as a share of what nothing else that is fitted
    /// takes over; and where a fit with it begins.
    fn in_place_of(&self, fit: &Fit, gone: &Term, other: &Term) -> Option<(f64, Vec<f64>)> {
        let place = |index: &usize| self.indices.binary_search(index).ok();
        let size: Vec<(usize, f64)> = gone
            .parameters
            .iter()
            .filter_map(|i| Some((place(i)?, fit.at[*i])))
            .collect();
        let across = |line: usize| -> f64 {
            size.iter()
                .map(|(column, own)| self.information[(line, *column)] * own)
                .sum()
        };
        let total: f64 = size.iter().map(|(line, own)| own * across(*line)).sum();
        let rest = fit
            .free
            .iter()
            .filter(|index| !gone.parameters.contains(index));
        let rest: Vec<usize> = rest.copied().collect();
        let taken = |indices: &[usize]| {
            let places: Vec<usize> = indices.iter().filter_map(place).collect();
            let count = places.len();
            let own = DMatrix::from_fn(count, count, |i, k| {
                self.information[(places[i], places[k])]
            });
            let across = DVector::from_fn(count, |i, _| across(places[i]));
            let step = own.cholesky()?.solve(&across);
            Some((across.dot(&step), step))
        };
        let (by_rest, _) = taken(&rest)?;
        let with = [rest.as_slice(), &other.parameters].concat();
        let (by_both, step) = taken(&with)?;
        let mut start = fit.at.clone();
        for index in &other.parameters {
            start[*index] = self.at[*index];
        }
        for (index, own) in with.iter().zip(step.iter()) {
            start[*index] += own;
        }
        for index in &gone.parameters {
            start[*index] = 0.0;
        }
        Some((
            (by_both - by_rest) / (total - by_rest).max(f64::MIN_POSITIVE),
            start,
        ))
    }
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

/// Score and information over all blocks.
struct Sums {
    gradient: DVector<f64>,
    information: DMatrix<f64>,
}

impl Sums {
    fn new(scores: &[BlockScore]) -> Self {
        let count = scores.first().map_or(0, |own| own.gradient.len());
        let mut sums = Self {
            gradient: DVector::zeros(count),
            information: DMatrix::zeros(count, count),
        };
        for block in scores {
            sums.gradient += &block.gradient;
            sums.information += &block.information;
        }
        sums
    }
}

/// Score and information of what is lacking, beside what is fitted.
struct Scores {
    /// By how much the fit is worse with lowered noise (nats).
    lost: f64,
    indices: Vec<usize>,
    gradient: DVector<f64>,
    information: DMatrix<f64>,
}

impl Scores {
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
