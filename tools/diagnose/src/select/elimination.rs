//! Backward elimination: from a fit with every term, those that the recording does not need go, the
//! least needed first; the rest is refitted each time, noise sizes included.

use nalgebra::{DMatrix, DVector};

use super::criterion::Criterion;
use super::effort::Effort;
use super::halves::Halves;
use super::selected::{Kept, Selected};
use crate::estimate::cluster::{LEAST_RUNS, Precision};
use crate::estimate::scoring::{Fit, Problem, SHORT, SearchLimits};
use crate::estimate::term::Term;

/// What one round of the elimination did.
enum EliminationRound {
    /// A fit without a term was better than the one with it: that one was not finished.
    Better(Fit),
    /// A term went.
    Removed(Fit, Vec<Term>),
    /// All that are left are needed.
    Done(Precision, Vec<Kept>),
}

/// Rounds after which an elimination that does not end is given up.
const MOST_ROUNDS: usize = 60;
/// Largest variance of what is known, as a share of the prior's.
pub(crate) const KNOWN_SHARE: f64 = 1.0 / 16.0;
/// A gain of this many times what is asked for does not come of an unfinished fit.
const CERTAIN: f64 = 10.0;
/// Wald statistic per parameter below which a term is idle: its expectation without any effect.
const IDLE: f64 = 1.0;
/// Share of the floors that is left between two recordings that have everything in common.
pub(crate) const LEAST_APART: f64 = 0.01;
/// A fit without a term that is better by this much shows that the fit with it was not finished
/// (nats).
const UNFINISHED_NATS: f64 = 0.2;

/// A search for the terms that are needed.
pub(crate) struct Elimination<'a> {
    pub(crate) problem: &'a Problem<'a>,
    /// Parameters that are always free and no noise sizes.
    pub(crate) always: Vec<usize>,
    /// Noise parameters, and those of them that are sizes.
    pub(crate) noise: &'a [usize],
    pub(crate) sizes: &'a [usize],
    /// How each parameter moves what the likelihood reads.
    pub(crate) weights: &'a [Vec<(usize, f64)>],
    /// The parts of the likelihood that each parameter moves, a bit for each.
    pub(crate) parts: &'a [u8],
    /// What the model has of each parameter that cannot be negative.
    pub(crate) nominal: &'a [f64],
    pub(crate) criterion: Criterion,
    /// The test by which blocks of time have to agree on a term that gains enough.
    pub(crate) agreement: Criterion,
    pub(crate) effort: Effort,
    /// Of each parameter that is a change, what runs from before have of it.
    pub(crate) twins: &'a [Option<usize>],
    /// Whether the fit with a term predicts better than the one without.
    pub(crate) useful: &'a (dyn Fn(&Term, &Fit, &Fit) -> bool + Sync),
}

impl Elimination<'_> {
    /// Parameters that are free with these terms: physics first, noise sizes last.
    pub(crate) fn free(&self, terms: &[Term]) -> (Vec<usize>, usize) {
        let mut free: Vec<usize> = self.always.clone();
        let smooth = terms.iter().filter(|term| !term.is_profiled());
        free.extend(smooth.flat_map(|term| &term.parameters));
        let physics = free.len();
        free.extend(self.noise);
        (free, physics)
    }

    /// `at` without a term, what it moved taken over by those of `others` that move the same and nothing else.
    pub(crate) fn carried(&self, at: &[f64], gone: &Term, others: &[usize]) -> Vec<f64> {
        let mut out = at.to_vec();
        for index in &gone.parameters {
            out[*index] = 0.0;
            for (read, weight) in &self.weights[*index] {
                let taker = others
                    .iter()
                    .find_map(|other| match self.weights[*other].as_slice() {
                        [(own, by)] if own == read => Some((*other, *by)),
                        _ => None,
                    });
                if let Some((other, by)) = taker {
                    out[other] += weight * at[*index] / by;
                }
            }
        }
        out
    }

    /// Fits with these terms from `start`, from which one of them has changed: what it cannot move stays.
    pub(crate) fn fit_near(
        &self,
        start: &[f64],
        terms: &[Term],
        changed: &Term,
        limits: SearchLimits,
    ) -> Fit {
        let (free, _) = self.free(terms);
        let of = |all: &[usize]| all.iter().fold(0, |sum, index| sum | self.parts[*index]);
        let moved = of(&changed.parameters);
        // a parameter of several parts carries what changes in one of them into the others
        let is_near = |index: &usize| self.parts[*index] & moved != 0;
        let spans = free.iter().any(|index| self.parts[*index].count_ones() > 1);
        let near: Vec<usize> = free
            .iter()
            .copied()
            .filter(|i| spans || is_near(i))
            .collect();
        let rest: Vec<usize> = free.iter().copied().filter(|i| !near.contains(i)).collect();
        let fit = self.problem.fit(start, &near, limits);
        Fit {
            objective: fit.objective + self.problem.log_prior(start, &rest),
            free,
            ..fit
        }
    }

    /// Fits with these terms, others at their neutral values, from `start`.
    pub(crate) fn fit(&self, start: &[f64], terms: &[Term], all: &[Term]) -> Fit {
        self.problem.fit(
            &self.without(start, terms, all),
            &self.free(terms).0,
            self.effort.full,
        )
    }

    /// `start` with terms that are not among `terms` at their neutral values.
    pub(crate) fn without(&self, start: &[f64], terms: &[Term], all: &[Term]) -> Vec<f64> {
        let mut at = start.to_vec();
        for term in all
            .iter()
            .filter(|t| terms.iter().all(|own| own.name != t.name))
        {
            for index in &term.parameters {
                at[*index] = 0.0;
            }
        }
        at
    }

    /// `at` with the logs of all noise sizes moved by so much.
    pub(crate) fn with_noise(&self, at: &[f64], shift: f64) -> Vec<f64> {
        let mut moved = at.to_vec();
        for index in self.sizes {
            moved[*index] += shift;
        }
        moved
    }

    /// The same from larger and from smaller noise: what was fitted with more terms may be too small a
    /// start, and what wanders may have settled too large.
    pub(crate) fn again(&self, start: &[f64], terms: &[Term], all: &[Term], first: Fit) -> Fit {
        let (free, _) = self.free(terms);
        [0.5, -0.5].into_iter().fold(first, |best, shift| {
            let at = self.with_noise(&self.without(start, terms, all), shift);
            let other = self.problem.fit(&at, &free, SHORT);
            if other.objective > best.objective + 0.5 {
                self.problem.fit(&other.at, &free, self.effort.full)
            } else {
                best
            }
        })
    }

    /// The fit without a term, what is left, and whether something stood in for it with an impossible sign,
    /// which is no explanation and went as well.
    pub(crate) fn removed(
        &self,
        fit: &Fit,
        gone: &Term,
        left: &[Term],
        terms: &[Term],
    ) -> (Fit, Vec<Term>, bool) {
        let others = left.iter().filter(|t| t.name != gone.name);
        let mut rest: Vec<Term> = others.cloned().collect();
        let start = self.without(&fit.at, &rest, terms);
        let left: Vec<usize> = rest
            .iter()
            .flat_map(|term| term.parameters.clone())
            .collect();
        let carried = self.carried(&fit.at, gone, &left);
        let starts = [start, carried].map(|own| (self.problem.objective(&own, &[]), own));
        let [own, other] = starts;
        let start = if other.0 > own.0 { other.1 } else { own.1 };
        let mut less = self.fit_near(&start, &rest, gone, SHORT);
        // what is needed by far is so whether or not the fit without it is finished
        if fit.objective - less.objective < CERTAIN * self.due(gone) {
            less = self.fit_near(&less.at, &rest, gone, self.effort.full);
        }
        let stands_in = rest.iter().any(|t| !self.is_possible(t, &less));
        if stands_in {
            rest.retain(|t| self.is_possible(t, &less));
            less = self.fit(&fit.at, &rest, terms);
        }
        if let Some(other) = self.without_change(fit, gone, &rest, terms)
            && other.objective > less.objective
        {
            less = other;
        }
        (less, rest, stands_in)
    }

    /// The fit without the change `gone` from where today's runs are: where a likelihood has several
    /// maxima, what both share may be at the one that only today's runs are at.
    fn without_change(&self, fit: &Fit, gone: &Term, rest: &[Term], all: &[Term]) -> Option<Fit> {
        let mut at = self.without(&fit.at, rest, all);
        let mut moved = false;
        for index in &gone.parameters {
            if let Some(base) = self.twins[*index]
                && fit.free.contains(&base)
            {
                at[base] += fit.at[*index];
                moved = true;
            }
        }
        moved.then(|| self.problem.fit(&at, &self.free(rest).0, self.effort.full))
    }

    /// Removes terms from `fit`, which has all of `terms`, until each that is left is needed.
    pub(crate) fn run(&self, fit: Fit, terms: &[Term]) -> Option<Selected> {
        let mut left = terms.to_vec();
        let mut fit = fit;
        for _ in 0..MOST_ROUNDS {
            match self.round(&fit, &left, terms)? {
                EliminationRound::Better(better) => fit = better,
                EliminationRound::Removed(less, rest) => (fit, left) = (less, rest),
                EliminationRound::Done(precision, kept) => {
                    return Some(Selected {
                        fit,
                        precision,
                        kept,
                        alike: Vec::new(),
                        halves: None,
                    });
                }
            }
        }
        None
    }

    /// The same for changes: those that may as well have been there before leave `terms` and become part of
    /// what all runs share.
    pub(crate) fn settled(&mut self, mut fit: Fit, terms: &mut Vec<Term>) -> Option<Selected> {
        loop {
            let found = self.run(fit, terms)?;
            let Some((term, moved)) = self.as_before(&found) else {
                return Some(found);
            };
            terms.retain(|own| own.name != term.name);
            self.criterion.tried = terms.len();
            self.agreement.tried = self.agreement.tried.min(terms.len());
            if !term.is_profiled() {
                let own = term.parameters.iter();
                self.always.extend(own.filter_map(|i| self.twins[*i]));
            }
            fit = moved;
        }
    }

    /// A change that may as well have been there before, where nothing is known of it: its term, and the fit
    /// in which runs from before have it too.
    fn as_before(&self, found: &Selected) -> Option<(Term, Fit)> {
        let unknown = |term: &Term| {
            let mut own = term.parameters.iter().map(|i| self.twins[*i]);
            own.all(|base| base.is_some_and(|base| !found.fit.free.contains(&base)))
        };
        let tried = found.kept.iter().filter(|kept| unknown(&kept.term));
        let tried = tried.filter_map(|kept| {
            let term = &kept.term;
            let mut at = found.fit.at.clone();
            let mut free = found.fit.free.clone();
            for index in &term.parameters {
                let base = self.twins[*index]?;
                at[base] += at[*index];
                at[*index] = 0.0;
                if let Some(own) = free.iter_mut().find(|f| *f == index) {
                    *own = base;
                }
            }
            let fit = self.problem.fit(&at, &free, self.effort.full);
            let least = self.due(term);
            let overdispersion = self.overdispersion(term, &found.fit, &found.precision);
            let loss = (found.fit.objective - fit.objective) / overdispersion;
            (loss < least).then(|| (loss, term.clone(), fit))
        });
        let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, term, fit)| (term, fit))
    }

    /// The same with what the halves of the blocks say by themselves, given as those that each leaves out. Rows
    /// of one course are compared pair by pair, and their halves with them.
    pub(crate) fn halved(&self, mut found: Selected, left_out: &[Vec<bool>; 2]) -> Selected {
        let kept: Vec<Term> = found.kept.iter().map(|kept| kept.term.clone()).collect();
        let (_, physics) = self.free(&kept);
        found.halves = Halves::new(self.problem, &found.fit, physics, left_out);
        found
    }

    /// Gain (nats) that a term has to bring.
    pub(crate) fn due(&self, term: &Term) -> f64 {
        self.criterion.least_gain(term.parameters.len()) + term.cost
    }

    /// By how much less a gain of this term counts, for its rows err together.
    fn overdispersion(&self, term: &Term, fit: &Fit, precision: &Precision) -> f64 {
        if term.rare {
            return 1.0;
        }
        precision.overdispersion(&fit.places(&term.parameters))
    }

    /// Tries to remove each term, the weakest first.
    fn round(&self, fit: &Fit, left: &[Term], terms: &[Term]) -> Option<EliminationRound> {
        let (_, physics) = self.free(left);
        let precision = Precision::new(self.problem, fit, physics)?;
        let walds: Vec<f64> = left.iter().map(|t| self.wald(t, fit, &precision)).collect();
        let share = |i: &usize| {
            if left[*i].is_decided_by_gain() {
                return 1.0;
            }
            walds[*i] / self.agreement.least_wald(left[*i].parameters.len())
        };
        let mut order: Vec<usize> = (0..left.len()).collect();
        order.sort_by(|a, b| share(a).total_cmp(&share(b)));
        if let Some(removed) = self.idle(fit, left, terms, &walds) {
            return Some(removed);
        }
        let mut kept = Vec::new();
        // of those that gain enough but are not known well enough, the one that gains least
        let mut weakest: Option<(f64, Fit, Vec<Term>)> = None;
        for i in order {
            let term = left[i].clone();
            let (mut less, rest, stands_in) = self.removed(fit, &term, left, terms);
            let least = self.due(&term);
            let gain = fit.objective - less.objective;
            if (least..least * CERTAIN).contains(&gain) {
                less = self.again(&fit.at, &rest, terms, less);
            }
            let gain = fit.objective - less.objective;
            if gain < -UNFINISHED_NATS {
                let better = self.problem.fit(&less.at, &fit.free, self.effort.full);
                if better.objective > fit.objective + UNFINISHED_NATS {
                    return Some(EliminationRound::Better(better));
                }
            }
            if gain / self.overdispersion(&term, fit, &precision) <= least {
                return Some(EliminationRound::Removed(less, rest));
            }
            if !self.needed(&term, gain, (walds[i], &precision), fit, &less) {
                // terms that stand in for each other are not known either: what costs least goes first
                let share = gain / least;
                if !stands_in && weakest.as_ref().is_none_or(|(own, ..)| share < *own) {
                    weakest = Some((share, less, rest));
                }
                continue;
            }
            kept.push(Kept {
                floors: self.floors(&term, fit),
                term,
                gain,
                wald: walds[i],
            });
        }
        Some(match weakest {
            Some((_, less, rest)) => EliminationRound::Removed(less, rest),
            None => EliminationRound::Done(precision, kept),
        })
    }

    /// Removes all terms at once that are far from being needed, where that costs nothing.
    fn idle(
        &self,
        fit: &Fit,
        left: &[Term],
        terms: &[Term],
        walds: &[f64],
    ) -> Option<EliminationRound> {
        let is_idle = |i: usize| {
            !left[i].is_decided_by_gain() && walds[i] < IDLE * left[i].parameters.len() as f64
        };
        let rest: Vec<Term> = (0..left.len())
            .filter(|i| !is_idle(*i))
            .map(|i| left[i].clone())
            .collect();
        if left.len() - rest.len() < 2 {
            return None;
        }
        let less = self.fit(&fit.at, &rest, terms);
        let parameters = left.iter().map(|t| t.parameters.len()).sum::<usize>();
        let gone = parameters - rest.iter().map(|t| t.parameters.len()).sum::<usize>();
        let gain = fit.objective - less.objective;
        (gain.abs() < 0.5 * IDLE * gone as f64 + UNFINISHED_NATS)
            .then_some(EliminationRound::Removed(less, rest))
    }

    /// Whether a term that gains enough passes: its Wald statistic, a gain without its best block, an
    /// estimate that the data know better than the prior, a possible sign, and its use for predictions.
    fn needed(
        &self,
        term: &Term,
        gain: f64,
        (wald, precision): (f64, &Precision),
        fit: &Fit,
        less: &Fit,
    ) -> bool {
        let count = term.parameters.len();
        let with = self.problem.likelihood.value(&fit.at);
        let without = self.problem.likelihood.value(&less.at);
        let gains: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
        let best = gains.iter().copied().fold(0.0, f64::max);
        let best = best.max(self.best_run(&gains));
        // along the estimate, the variance is a small share of the prior's
        let of_prior = |index: &usize| {
            let change = fit.at[*index];
            (change / self.problem.priors[*index].reach()).powi(2)
        };
        let floors = self.scaled(&term.resolution, fit);
        let by_data = self.wald_beside(term, fit, precision, &floors);
        let known = term.parameters.iter().map(of_prior).sum::<f64>() < KNOWN_SHARE * by_data;
        let clear =
            known && wald > self.agreement.least_wald(count) * term.inflation * term.inflation;
        self.is_possible(term, fit)
            && (clear || term.is_decided_by_gain())
            && (gain - best > 0.0 || term.rare)
            && (!term.needs_relevance || (self.useful)(term, fit, less))
    }

    /// Whether a term that cannot be negative is not; of a change, what comes of it.
    pub(crate) fn is_possible(&self, term: &Term, fit: &Fit) -> bool {
        let base = |index: usize| self.twins[index].map_or(0.0, |base| fit.at[base]);
        let value = |index: usize| fit.at[index] + base(index) + self.nominal[index];
        !term.positive || term.parameters.iter().all(|i| value(*i) >= 0.0)
    }

    /// Gain of the run that gains most, where there are enough runs to do without it.
    fn best_run(&self, gains: &[f64]) -> f64 {
        let runs = self.problem.likelihood.run_of();
        let count = runs.last().map_or(0, |run| run + 1);
        let of = |run: usize| {
            gains
                .iter()
                .zip(&runs)
                .filter(|(_, r)| **r == run)
                .map(|(g, _)| g)
                .sum()
        };
        let sums = (0..count).map(of).fold(0.0, f64::max);
        if count >= LEAST_RUNS { sums } else { 0.0 }
    }

    /// Variances of a term's parameters that nobody would call a difference. Recordings that have nearly
    /// everything in common are that much nearer to being one, and less lies between them.
    pub(crate) fn floors(&self, term: &Term, fit: &Fit) -> Vec<f64> {
        let pairs = term.resolution.iter().zip(&term.repeatability);
        let all: Vec<f64> = pairs.map(|(floor, own)| floor + own).collect();
        self.scaled(&all, fit)
    }

    fn scaled(&self, floors: &[f64], fit: &Fit) -> Vec<f64> {
        let apart = self.problem.likelihood.apart(&fit.at).max(LEAST_APART);
        floors.iter().map(|own| apart * own).collect()
    }

    /// d' V⁻¹ d of a term's parameters, with its floors.
    pub(crate) fn wald(&self, term: &Term, fit: &Fit, precision: &Precision) -> f64 {
        self.wald_beside(term, fit, precision, &self.floors(term, fit))
    }

    fn wald_beside(&self, term: &Term, fit: &Fit, precision: &Precision, floors: &[f64]) -> f64 {
        let places = fit.places(&term.parameters);
        let k = places.len();
        if term.is_decided_by_gain() || k < term.parameters.len() {
            return 0.0;
        }
        let d = DVector::from_iterator(k, term.parameters.iter().map(|i| fit.at[*i]));
        let v = DMatrix::from_fn(k, k, |i, j| {
            precision.covariance[(places[i], places[j])] + if i == j { floors[i] } else { 0.0 }
        });
        v.cholesky().map_or(0.0, |c| d.dot(&c.solve(&d)))
    }
}
