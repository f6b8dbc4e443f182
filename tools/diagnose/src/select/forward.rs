//! Forward selection: the term that is lacking most is added, as long as one brings what is due.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::chosen::Chosen;
use super::criterion::BETTER_NATS;
use super::elimination::Elimination;
use super::screen::{Candidate, LOWERED_MORE};
use crate::estimate::scoring::Fit;
use crate::estimate::term::Term;

/// Share of what the best of them brings from which on another one is a rival.
const NEAR: f64 = 0.3;
/// A located term is refined while that gains this much (nats).
const REFINED_NATS: f64 = 2.0;

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
            self.problem
                .fit(&self.with_noise(&at, -lowered), &free, self.effort.full)
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
        let best = self.best(chosen, &self.screened(chosen, all));
        let rival = best.as_ref().map_or(&chosen.fit, |own| &own.fit);
        let located = self.best(chosen, &self.located(chosen, rival, all));
        let both = best.into_iter().chain(located);
        let best = both.max_by(|a, b| self.by_excess(&chosen.fit, a, b));
        best.filter(|own| self.worth(own) > self.worth(chosen))
    }

    /// What the last term brings beyond what is due.
    fn excess(&self, fit: &Fit, own: &Chosen) -> f64 {
        let due = own.terms.last().map_or(0.0, |term| self.due(term));
        own.fit.objective - fit.objective - due
    }

    /// The order of two sets by what their last terms bring.
    fn by_excess(&self, fit: &Fit, a: &Chosen, b: &Chosen) -> Ordering {
        self.excess(fit, a).total_cmp(&self.excess(fit, b))
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
        let first = candidates
            .par_iter()
            .take(self.effort.refitted)
            .flat_map(|own| {
                let starts = own.starts.par_iter();
                starts.map(|start| (own.term, start))
            });
        let short = first.map(|(term, start)| with(term, start, self.effort.ranked));
        let mut short: Vec<Chosen> = short.collect();
        short.sort_by(|a, b| self.by_excess(&chosen.fit, b, a));
        // of one term the better start alone
        let mut seen: Vec<&str> = Vec::new();
        short.retain(|own| {
            let name = own.terms.last().map_or("", |term| term.name);
            let is_new = !seen.contains(&name);
            seen.push(name);
            is_new
        });
        let most = short
            .first()
            .map_or(0.0, |own| self.excess(&chosen.fit, own));
        let near = |own: &&Chosen| self.excess(&chosen.fit, own) > NEAR * most;
        let rivals: Vec<&Chosen> = short
            .iter()
            .take(self.effort.converged)
            .filter(near)
            .collect();
        let converged = rivals.into_par_iter().filter_map(|own| {
            let term = own.terms.last()?;
            let mut own = with(term, &own.fit.at, self.effort.full);
            while let Some(at) = self.problem.likelihood.refined(term, &own.fit.at) {
                let other = with(term, &at, self.effort.full);
                if other.fit.objective < own.fit.objective + REFINED_NATS {
                    break;
                }
                own = other;
            }
            self.is_possible(term, &own.fit).then_some(own)
        });
        let converged: Vec<Chosen> = converged.collect();
        let converged = converged.into_iter();
        converged.max_by(|a, b| self.by_excess(&chosen.fit, a, b))
    }
}
