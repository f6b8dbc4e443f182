//! Exchange: each term is tried against its look-alikes in its place, and terms that others make needless go.

use nalgebra::{DMatrix, DVector};

use super::chosen::Chosen;
use super::criterion::{BETTER_NATS, TIE_NATS};
use super::elimination::Elimination;
use crate::estimate::scoring::{Fit, summed};
use crate::estimate::term::{Search, Term};

/// A term is tried in the place of another from which it would take over this share.
const LOOK_ALIKE: f64 = 0.25;
/// A short fit that is worse by more is not finished (nats).
const UNFINISHED_NATS: f64 = 15.0;
/// A term may be needless that would cost less than so many times what is due, were the likelihood quadratic.
const IDLE: f64 = 2.0;
/// Most exchanges of one selection.
const EXCHANGES: usize = 6;

impl Elimination<'_> {
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

    /// The same without terms that others make needless.
    pub(super) fn lightened(&self, mut chosen: Chosen, all: &[Term]) -> Chosen {
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
            let places = fit.places(&term.parameters);
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
        let lacking: Vec<&Term> = lacking.filter(|term| term.is_smooth()).collect();
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
            let mut with = with(&start, self.effort.look_alike);
            if self.worth(&with) < self.worth(chosen) - UNFINISHED_NATS {
                continue;
            }
            with.fit = self.fit_near(&with.fit.at, &terms, &both, self.effort.full);
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
                && let Some(first) = starts.first()
                && begins(term, first)
            {
                for (index, own) in term.parameters.iter().zip(first) {
                    at[*index] = *own;
                }
            }
            let new = term
                .parameters
                .iter()
                .filter(|index| !fit.free.contains(index));
            indices.extend(new.copied().collect::<Vec<_>>());
        }
        indices.sort_unstable();
        indices.dedup();
        let scores = self.problem.likelihood.score(&at, &indices);
        let (_, mut information) = summed(&scores, indices.len());
        self.problem.add_priors(&mut information, &at, &indices);
        Overlap {
            at,
            indices,
            information,
        }
    }
}

/// Whether a term does nothing where it is 0, or is left out there, so that it is looked at from its first start on.
fn begins(term: &Term, first: &[f64]) -> bool {
    let is_law = first.iter().all(|own| *own == f64::MIN_POSITIVE);
    term.kinked && first.len() == 1 || is_law
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
