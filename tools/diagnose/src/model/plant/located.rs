//! Where effects begin to be looked for that act at one time or place, or when something gives way: pushes by a
//! backward pass, slip by trying frictions, patches by trying places along the way.

use std::collections::BTreeMap;

use rayon::prelude::*;
use slipstream_sim::effects::When;

use super::channels::{precisions, weights};
use super::filtered::Filtered;
use super::likelihood::{AtGains, Plant};
use super::machine::Machine;
use crate::estimate::scoring::SearchLimits;
use crate::estimate::term::Term;
use crate::filter::dynamic::impulse::{Impulse, impulses};
use crate::filter::dynamic::linear::likelihood;
use crate::filter::wrapped;
use crate::model::hypothesis::{Hypothesis, momentary_and_placed};

/// A push lasts this long (s); its first instant lies half of it before the middle.
const PUSH_S: f64 = 0.06;
/// Impulses that are less apart are of one push (s).
const APART_S: f64 = 0.5;
/// Share of the gain of a push above which another one shows that it is not the only one.
const ONLY: f64 = 0.3;
/// Gain (−2 ln L) at fixed gains below which slip is not looked at with gains of its own.
const SLIP_GAIN: f64 = 6.0;
/// Frictions that are looked at with gains of their own.
const SLIPS: usize = 4;
/// Length of a moment (s), and how many innovations it has at least; mean square of them, over that of
/// all, from which on something pushes. Of eight that are noise one in 500 moments exceeds it, of the usual
/// 50 none.
const MOMENT_S: f64 = 0.25;
const FEWEST: f64 = 8.0;
const PUSHED: f64 = 3.0;

/// A fit at fixed gains, and how often it takes turns with one of the noise while that gains so much (nats).
const AT_GAINS: SearchLimits = SearchLimits {
    iterations: 8,
    tolerance_nats: 0.5,
};
const TURNS: usize = 6;
const LEAST_NATS: f64 = 2.0;

impl Plant<'_> {
    /// Where fits of a term begin beside `at`; `rival` is the best fit with another one. Nothing slides where it leaves
    /// nothing by which wheels and floor part company, and at no place where it leaves no push.
    pub(super) fn places(&self, term: &Term, at: &[f64], rival: &[f64]) -> Vec<Vec<f64>> {
        let acts = self.table.starts(term).first().map(|own| own.info.acts);
        let found = match acts {
            Some(When::Once) => self.push(at).map(|own| vec![self.table.with(at, &own)]),
            Some(When::Inside) if self.parts(rival) && self.is_pushed(rival) => self.patches(at),
            Some(When::Sliding) if self.parts(rival) => self.frictions(term, at),
            _ => None,
        };
        found.unwrap_or_default()
    }

    /// Whether wheels and floor part company in a way that a fit leaves to its noise: without the creep of the
    /// contacts it is clearly worse. Where wheels slide already, or no pose tells, they may.
    fn parts(&self, at: &[f64]) -> bool {
        let Some(fit) = self.filtered(at) else {
            return false;
        };
        if fit.noise.of_wheels || !self.machine.has_pose() {
            return true;
        }
        let mut still = fit.noise;
        still.size[2..].copy_from_slice(&self.machine.floor(false)[2..]);
        let (mut whitened, mut own) = (Vec::with_capacity(fit.whitened.len()), 0.0);
        for (run, pass) in self.machine.runs.iter().zip(&fit.passes) {
            let of_run = likelihood(pass, run, &still);
            whitened.extend(of_run.whitened);
            own += of_run.log_determinants.iter().sum::<f64>();
        }
        self.machine.deviance(&whitened) + own > fit.deviance + SLIP_GAIN
    }

    /// Whether something pushes the robot for a moment: by the largest mean square of innovations within one.
    fn is_pushed(&self, at: &[f64]) -> bool {
        let Some(fit) = self.filtered(at) else {
            return false;
        };
        let mut moments: BTreeMap<(usize, i64), [f64; 2]> = BTreeMap::new();
        let precisions = precisions(&fit.whitened, &self.machine.channels);
        let all = fit
            .whitened
            .iter()
            .zip(&precisions)
            .zip(&self.machine.stamps);
        for ((e, precision), (stamp_s, run)) in all.filter(|own| *own.0.1 > 0.0) {
            let moment = moments.entry((*run, (stamp_s / MOMENT_S) as i64));
            let [sum, count] = moment.or_default();
            *sum += e * e * precision;
            *count += 1.0;
        }
        let mut each = moments.values().filter(|[_, count]| *count >= FEWEST);
        each.any(|[sum, count]| sum / count > PUSHED)
    }

    /// What acts in `fit` under the noise of `at`, which acts on the wheels.
    pub(super) fn with_noise_of_wheels(&self, fit: &Filtered, at: &[f64]) -> Option<Filtered> {
        self.machine
            .pass(fit.hypotheses.clone(), self.noise(at, true))
    }

    /// Frictions that gain most: at the gains of small noise that acts on the wheels, where what slides is told from
    /// what pushes; where none fits there, at those of the fit.
    fn frictions(&self, term: &Term, at: &[f64]) -> Option<Vec<Vec<f64>>> {
        let fit = self.filtered(at)?;
        let small = self.table.with_expected_noise(at);
        let base = self.with_noise_of_wheels(&fit, &small)?;
        let ranked = |base: &Filtered| {
            let still = base.deviance - base.log_determinant();
            let gains = self.table.starts(term).par_iter().filter_map(|own| {
                let e = self.machine.bounded_innovations(base, &base.beside(own))?;
                Some((still - self.machine.deviance(&e), own))
            });
            let ranked = gains.filter(|(gain, _)| *gain > SLIP_GAIN);
            let mut ranked: Vec<(f64, &Hypothesis)> = ranked.collect();
            ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
            ranked.truncate(SLIPS);
            ranked
        };
        let mut leaders = ranked(&base);
        if leaders.is_empty() {
            leaders = ranked(&fit);
        }
        Some(
            leaders
                .into_iter()
                .map(|(_, own)| self.table.with(&small, own))
                .collect(),
        )
    }

    /// What acts on the robot fitted at the gains of `at`, and the noise there, in turn while that gains.
    pub(super) fn at_its_gains(&self, mut at: Vec<f64>) -> Vec<f64> {
        let problem = self.table.problem(self);
        let free = self.table.acting_parameters(&at);
        let objective =
            |at: &[f64]| problem.objective(at, &free) + problem.log_prior(at, &self.table.told);
        let mut best = objective(&at);
        for _ in 0..TURNS {
            let Some(base) = self.filtered(&at) else {
                break;
            };
            let held = AtGains {
                plant: self,
                base: &base,
            };
            let moved = self.table.problem(&held).fit(&at, &free, AT_GAINS);
            let next = problem.fit(&moved.at, &self.table.told, AT_GAINS);
            let value = objective(&next.at);
            let gain = value - best;
            if gain > 0.0 {
                (best, at) = (value, next.at);
            }
            if gain < LEAST_NATS {
                break;
            }
        }
        at
    }

    /// The push that gains most.
    fn push(&self, at: &[f64]) -> Option<Hypothesis> {
        let fit = self.filtered(at)?;
        let all = self.machine.impulses(&fit);
        let (run, impulse) = largest(&all)?;
        // what pushes more than once follows something, or is nothing to name
        if pushes(all, ONLY * impulse.gain) > 1 {
            return None;
        }
        let mut heading = 0.0;
        self.machine
            .watched(&fit, &fit.hypotheses, |index, t_s, state, _| {
                if index == run && t_s <= impulse.t_s {
                    heading = state.pose()[2];
                }
            })?;
        let [along, across] = impulse.size;
        let mut own = momentary_and_placed().find(Hypothesis::is_momentary)?;
        own.set("t_s", (impulse.t_s - 0.5 * PUSH_S).max(0.0));
        own.set("impulse_n_s", along.hypot(across));
        own.set("direction_rad", wrapped(heading + across.atan2(along)));
        Some(own)
    }
}

impl Machine {
    /// Impulses beside `fit` in every interval that is believed, each with its run.
    pub(crate) fn impulses(&self, fit: &Filtered) -> Vec<(usize, Impulse)> {
        let weights = weights(&fit.whitened, &self.channels);
        let lever = self.model.robot.com_to_axle_m.unwrap_or(0.0);
        let mut first = 0;
        let mut all = Vec::new();
        for (run, pass) in fit.passes.iter().enumerate() {
            let end = first + 3 * self.runs[run].rows.len();
            let own = impulses(pass, &fit.whitened[first..end], &weights[first..end], lever);
            let left_out = &self.runs[run].left_out_s;
            let believed = |impulse: &Impulse| {
                let mut near = left_out.iter();
                !near.any(|[from, to]| (from - PUSH_S..=to + PUSH_S).contains(&impulse.t_s))
            };
            all.extend(own.into_iter().filter(believed).map(|own| (run, own)));
            first = end;
        }
        all
    }

    /// The impulse that gains most beside `fit`, and its run.
    pub(crate) fn impulse(&self, fit: &Filtered) -> Option<(usize, Impulse)> {
        largest(&self.impulses(fit))
    }
}

/// The impulse that gains most, and its run.
fn largest(all: &[(usize, Impulse)]) -> Option<(usize, Impulse)> {
    let all = all.iter().copied();
    all.reduce(|best, own| if own.1.gain > best.1.gain { own } else { best })
}

/// How many pushes, each by itself, gain `due` (−2 ln L).
pub(crate) fn pushes(mut all: Vec<(usize, Impulse)>, due: f64) -> usize {
    all.retain(|(_, own)| own.gain > due);
    all.sort_by(|a, b| b.1.gain.total_cmp(&a.1.gain));
    let mut apart: Vec<(usize, f64)> = Vec::new();
    for (run, own) in all {
        let mut known = apart.iter();
        if known.all(|(known, t_s)| *known != run || (own.t_s - t_s).abs() > APART_S) {
            apart.push((run, own.t_s));
        }
    }
    apart.len()
}
