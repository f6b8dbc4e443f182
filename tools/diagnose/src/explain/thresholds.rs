//! Thresholds of commands: a likelihood that has several maxima by a saturation, and no derivative by a
//! dead band, is searched by profiles.

use super::term::{BAND_TERM, SATURATION_TERM};
use crate::data::command::CommandPath;
use crate::estimate::scoring::{FULL, Fit, Problem, SHORT};
use crate::model::drive::{DEAD_BAND, SATURATION};
use crate::select::elimination::Term;

/// Saturations from which the search starts, as shares of the largest command.
const SATURATIONS: [f64; 7] = [0.98, 0.93, 0.87, 0.8, 0.72, 0.63, 0.53];
/// A start this much worse than the best fit is not followed (nats).
const FOLLOWED_NATS: f64 = 20.0;
/// A threshold that gains less is none (nats).
const WORTH_NATS: f64 = 2.0;
/// Half of the chi-square of one parameter at 95 %: dead bands within it fit as well (nats).
const ALIKE_NATS: f64 = 1.92;
/// Most dead bands that are tried.
const BANDS: usize = 12;

/// The search for thresholds of a drive whose parameters begin at `first`.
pub(super) struct Thresholds<'a> {
    pub(super) problem: &'a Problem<'a>,
    pub(super) first: usize,
    /// Largest command (rad/s).
    pub(super) top_rad_s: f64,
    /// Distinct sizes of commands (rad/s), rising.
    pub(super) levels_rad_s: Vec<f64>,
    /// Whether runs from before have a saturation and a dead band, if there are any.
    pub(super) known: Option<[bool; 2]>,
}

/// Distinct sizes of all commands but 0 (rad/s), rising.
pub(super) fn levels<'a>(commands: impl Iterator<Item = &'a CommandPath>) -> Vec<f64> {
    let all = commands.flat_map(|path| path.speeds_rad_s.iter().flatten());
    let sizes = all.map(|speed| speed.abs()).filter(|size| *size > 1e-9);
    let mut levels: Vec<f64> = sizes.collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    levels
}

impl Thresholds<'_> {
    /// `best` with a saturation, where one fits better; else its term is taken out.
    pub(super) fn saturated(&self, best: Fit, terms: &mut Vec<Term>) -> Fit {
        let own = |t: &Term| t.name == SATURATION_TERM;
        let index = self.first + SATURATION;
        let mut free = vec![index];
        free.extend(best.free.iter().filter(|i| **i != index));
        if self.known.is_some_and(|[known, _]| known) && terms.iter().any(own) {
            // its change has a derivative
            return self.problem.fit(&best.at, &free, FULL);
        }
        let of = |share: &f64| {
            let mut at = best.at.clone();
            if at[index] == 0.0 {
                at[index] = share * self.top_rad_s;
            }
            (self.problem.objective(&at, &free), at)
        };
        let found = terms.iter().any(own).then(|| {
            let tried = SATURATIONS.iter().map(of);
            let (value, at) = tried.max_by(|a, b| a.0.total_cmp(&b.0))?;
            let follows = value > best.objective - FOLLOWED_NATS;
            follows.then(|| self.problem.fit(&at, &free, SHORT))
        });
        match found.flatten() {
            Some(limited) if limited.objective > best.objective + WORTH_NATS => {
                self.problem.fit(&limited.at, &free, FULL)
            }
            _ => {
                terms.retain(|t| !own(t));
                best
            }
        }
    }

    /// `best` with the dead band that fits best, and the levels between which it lies (rad/s); without
    /// one that fits better its term is taken out.
    pub(super) fn banded(&self, best: Fit, terms: &mut Vec<Term>) -> (Fit, [f64; 2]) {
        let known = self.known.is_some_and(|[_, known]| known);
        // the level that a dead band lies between cannot change by part of a step
        let own = |t: &Term| t.name == BAND_TERM && !known;
        let gaps: Vec<[f64; 2]> = self.levels_rad_s.windows(2).map(|p| [p[0], p[1]]).collect();
        let stride = gaps.len().div_ceil(BANDS).max(1);
        let of = |gap: [f64; 2]| {
            let mut at = best.at.clone();
            at[self.first + DEAD_BAND] = f64::midpoint(gap[0], gap[1]);
            (self.problem.objective(&at, &best.free), at, gap)
        };
        let found = terms.iter().any(own).then(|| {
            let coarse = (0..gaps.len()).step_by(stride).map(|i| (i, of(gaps[i])));
            let (at, coarse) = coarse.max_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
            let near = at.saturating_sub(stride)..(at + stride).min(gaps.len());
            let fine: Vec<_> = near.map(|i| of(gaps[i])).chain([coarse]).collect();
            let best = fine.iter().max_by(|a, b| a.0.total_cmp(&b.0))?.clone();
            // gaps beside it that fit nearly as well
            let as_well = fine
                .iter()
                .filter(|(value, ..)| *value > best.0 - ALIKE_NATS);
            let [low, high] = as_well.fold(best.2, |[low, high], (_, _, gap)| {
                [low.min(gap[0]), high.max(gap[1])]
            });
            Some((best.0, best.1, [low, high]))
        });
        match found.flatten() {
            Some((value, at, gap)) if value > best.objective + WORTH_NATS => {
                (self.problem.fit(&at, &best.free, FULL), gap)
            }
            _ => {
                terms.retain(|t| t.name != BAND_TERM);
                (best, [0.0; 2])
            }
        }
    }
}
