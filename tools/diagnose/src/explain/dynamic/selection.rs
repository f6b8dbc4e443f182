//! Which effects a recording needs: forward by the best that is lacking, each refitted with its noise;
//! then backward.

use rayon::prelude::*;
use slipstream_sim::effects::find;

use super::channels::levels;
use super::fit::{Fit, least_change, values};
use super::machine::Machine;
use super::precision::Known;
use super::screen::{Candidate, beside};
use super::unknown::Unknown;
use crate::model::hypothesis::{Hypothesis, KINETIC, is_where, kinds};
use crate::select::criterion::{Criterion, TIE_NATS};

/// Candidates that are refitted with their noise, and of these the ones that are fitted to the end.
const REFITTED: usize = 7;
const POLISHED: usize = 4;
/// Candidates of the effect that was found last which are refitted beside it whatever they gain at a glance.
const AGAIN: usize = 3;
/// Gain at fixed gains (−2 ln L) below which a candidate is not refitted.
const GLANCE_GAIN: f64 = 6.0;
/// Most effects.
const MOST: usize = 5;
/// Kinetic friction from which on no wheel is said to slip: rubber on a clean floor has 1.
const GRIPS: f64 = 1.2;
/// Share of a gain that has to be left without its best block, and the gain (−2 ln L) from which on one
/// block is enough.
const REST: f64 = 0.3;
const CERTAIN: f64 = 200.0;
/// Share of a gain that an effect has to keep beside a force outside of the catalogue: less may be that
/// force's as well.
const TAKEN: f64 = 0.3;
/// Multiple of what integrators differ by below which a force outside of the catalogue is none.
const SMALL: f64 = 4.0;
/// Effects that act by the speed alone, or by the turn rate: from a force outside of the catalogue that
/// does so they cannot be told.
const OF_SPEED: [&str; 4] = [
    "rolling_resistance",
    "axle_friction",
    "viscous_drag",
    "quadratic_drag",
];
const OF_TURN: [&str; 1] = ["yaw_scrub"];
/// Blocks without which a force outside of the catalogue still has to gain so much.
const RARE: usize = 2;
/// Multiple of its floor below which a disturbance is none, and mean square of innovations that is
/// noise.
const QUIET: f64 = 1.05;
const QUIET_LEVEL: f64 = 1.15;
/// Gain (−2 ln L) by which encoders that count wrong have to fit better than wheels of another radius.
const FIRST_SUSPECT: f64 = 12.0;
/// What a gain (−2 ln L) has to bring beyond the criterion: fits are finished to a few.
const MARGIN: f64 = 12.0;
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
    /// What the catalogue does not hold.
    pub(crate) unknown: Option<Unknown>,
}

impl Selected {
    /// Whether an effect is named: one that cannot be told from a force outside of the catalogue is part
    /// of that force.
    pub(crate) fn names(&self, own: &Hypothesis) -> bool {
        let part = |unknown: &Unknown| match unknown.driver {
            "v" => OF_SPEED.contains(&own.info.id),
            "w" => OF_TURN.contains(&own.info.id),
            _ => false,
        };
        !self.unknown.as_ref().is_some_and(part)
    }

    /// The fit of everything that was found.
    pub(crate) fn whole(&self) -> &Fit {
        self.unknown.as_ref().map_or(&self.fit, |own| &own.fit)
    }
}

/// What a selection comes to.
enum Course {
    Found(Box<Selected>),
    /// More than one push was needed, for this gain (−2 ln L) over the nominal model.
    Gusts(f64),
}

/// A selection on one machine.
pub(crate) struct Selection<'a> {
    pub(crate) machine: Machine,
    pub(crate) all: &'a [Hypothesis],
    /// What acts in runs from before.
    pub(crate) known: &'a [Hypothesis],
    pub(crate) progress: &'a (dyn Fn(&str) + Sync),
}

impl Selection<'_> {
    fn tried(&self) -> usize {
        kinds(self.all).len()
    }

    fn criterion(&self, known: Option<&Known>) -> Criterion {
        Criterion {
            tried: self.tried(),
            blocks: known.map_or(2, |known| known.blocks),
        }
    }

    /// −2 ln L that so many numbers have to bring.
    fn due_of(&self, numbers: usize) -> f64 {
        2.0 * self.criterion(None).least_gain(numbers) + MARGIN
    }

    /// −2 ln L that an effect has to bring.
    fn due(&self, hypothesis: &Hypothesis) -> f64 {
        self.due_of(hypothesis.values.len())
    }

    pub(crate) fn run(&mut self) -> Option<Selected> {
        (self.progress)("fitting the model as it is");
        let nominal = self.machine.nominal(self.known)?;
        let gain = match self.from(nominal.clone())? {
            Course::Found(selected) => return Some(*selected),
            Course::Gusts(gain) => gain,
        };
        // what pushes more than once follows something, or is nothing to name
        self.machine.excluded.push("push".to_owned());
        let Course::Found(selected) = self.from(nominal.clone())? else {
            return None;
        };
        if nominal.deviance - selected.whole().deviance > gain {
            return Some(*selected);
        }
        (self.progress)("looking for single pushes");
        let push = find("push").map(|info| info.parameters.len());
        let due = self.due_of(push.unwrap_or(1));
        let nominal = self.machine.mark_gusts(nominal, due)?;
        match self.from(nominal)? {
            Course::Found(selected) => Some(*selected),
            Course::Gusts(_) => None,
        }
    }

    /// The selection from the nominal model on.
    fn from(&self, nominal: Fit) -> Option<Course> {
        let mut fit = nominal.clone();
        let mut rivals: Vec<(String, Vec<&'static str>)> = Vec::new();
        let mut less: Vec<Option<Fit>> = Vec::new();
        let mut earlier: Vec<Hypothesis> = Vec::new();
        let changes = |fit: &Fit| fit.hypotheses.iter().filter(|h| self.is_judged(h)).count();
        while changes(&fit) < MOST && fit.hypotheses.len() < 2 * MOST && !self.is_silent(&fit) {
            let Some((next, near)) = self.extended(&fit, &mut earlier) else {
                break;
            };
            let pushes = next.hypotheses.iter().filter(|h| h.is_momentary());
            if pushes.count() > 1 {
                return Some(Course::Gusts(nominal.deviance - next.deviance));
            }
            let id = next.hypotheses.last()?.info.id.to_owned();
            rivals.push((id, near));
            if !self.is_silent(&next) {
                fit = self.machine.with_best_noise(next);
                fit = self.machine.fitted(fit, 2, 6);
            } else {
                fit = next;
            }
            (fit, less) = self.pruned(fit);
            if !self.is_silent(&fit) {
                (fit, less) = self.swapped(fit, less, &mut rivals);
            }
        }
        let unknown = if self.is_silent(&fit) || self.machine.before > 0 {
            None
        } else {
            self.outside(&mut fit, &mut less)
        };
        let (gains, alike) = self.weighed(&fit, &less, &rivals);
        Some(Course::Found(Box::new(Selected {
            nominal,
            fit,
            gains,
            alike,
            tried: self.tried(),
            unknown,
        })))
    }

    /// A force outside of the catalogue beside `fit`, which loses the effects that are not needed
    /// beside it.
    fn outside(&self, fit: &mut Fit, less: &mut Vec<Option<Fit>>) -> Option<Unknown> {
        (self.progress)("looking for forces that no effect explains");
        let mut unknown = self.machine.unknown(fit)?;
        // rare gusts, each at a place of its own, look like a force that follows the place
        let gains = self.gains_by_block(fit, &unknown.fit);
        let spread: f64 = gains.iter().skip(RARE).sum();
        let floor = self.machine.floor(fit.noise.of_wheels);
        let small = (0..2).all(|i| unknown.largest[i] < SMALL * floor[i]);
        let rare = unknown.driver != "t" && spread < REST * unknown.gain;
        if unknown.gain < self.due_of(unknown.numbers) || rare || small {
            return None;
        }
        while !fit.hypotheses.is_empty() {
            let without = less.iter().enumerate().filter_map(|(at, less)| {
                let less = less.as_ref()?;
                let own = self.machine.unknown(less)?;
                let rise = own.fit.deviance - unknown.fit.deviance;
                let brought = less.deviance - fit.deviance;
                let needed = self.due(&fit.hypotheses[at]).max(TAKEN * brought);
                (rise < needed).then_some((less.clone(), own))
            });
            let best = without.min_by(|a, b| a.1.fit.deviance.total_cmp(&b.1.fit.deviance));
            let Some((fewer, own)) = best else { break };
            (*fit, unknown) = (fewer, own);
            *less = self.all_without(fit);
        }
        Some(unknown)
    }

    /// Whether no disturbance is left above what integrators differ by, and every channel is at its
    /// noise.
    fn is_silent(&self, fit: &Fit) -> bool {
        let floor = self.machine.floor(fit.noise.of_wheels);
        let used = if self.machine.has_pose() { 5 } else { 2 };
        let quiet = (0..used).all(|i| fit.noise.size[i] < QUIET * floor[i]);
        let levels = levels(&fit.whitened, &self.machine.channels);
        quiet && levels.iter().all(|[mean, _]| *mean < QUIET_LEVEL)
    }

    /// `fit` with the effect that is lacking most, and those that fit as well in its place.
    fn extended(
        &self,
        fit: &Fit,
        earlier: &mut Vec<Hypothesis>,
    ) -> Option<(Fit, Vec<&'static str>)> {
        let names: Vec<&str> = fit.hypotheses.iter().map(|h| h.info.id).collect();
        (self.progress)(&match names.is_empty() {
            true => "trying every effect".to_owned(),
            false => format!("trying effects beside {}", names.join(", ")),
        });
        let mut candidates = self.machine.screened(fit, self.all);
        candidates.retain(|candidate| candidate.gain > GLANCE_GAIN);
        candidates.truncate(REFITTED);
        // what looked like an effect that was found may act beside it, and show only when both are fitted
        let known: Vec<&Hypothesis> = candidates.iter().map(|own| &own.hypothesis).collect();
        let is_new = |own: &&Hypothesis| {
            let mut known = known.iter();
            !own.is_local() && !fit.has(own) && !known.any(|known| known.is_like(own))
        };
        let again = earlier.iter().filter(is_new).take(AGAIN).cloned();
        let again: Vec<Candidate> = again.map(Candidate::earlier).collect();
        *earlier = candidates
            .iter()
            .map(|own| own.hypothesis.clone())
            .collect();
        candidates.extend(again);
        let refits = candidates.par_iter().filter_map(|candidate| {
            let begun = match &candidate.fit {
                Some(begun) => begun.clone(),
                None => self
                    .machine
                    .begun(fit, beside(fit, &candidate.hypothesis))?,
            };
            Some(self.refitted(begun, 2, 5))
        });
        let leaders = self.leaders(fit, refits.collect(), -MARGIN);
        let polished = leaders.into_par_iter().map(|own| self.refitted(own, 6, 8));
        let mut polished = self.leaders(fit, polished.collect(), 0.0).into_iter();
        let best = polished.next()?;
        if !self.is_clear(&best) || !self.is_lasting(fit, &best) {
            return None;
        }
        let excess = self.excess(fit, &best);
        let near = polished
            .filter(|own| self.excess(fit, own) > excess - 2.0 * TIE_NATS)
            .filter_map(|own| Some(own.hypotheses.last()?.info.id));
        let near = near.collect();
        Some(match self.as_before(&best) {
            Some(other) => (other, Vec::new()),
            None => (best, near),
        })
    }

    /// Whether an effect is looked for: of runs that are compared, one of today's alone.
    fn is_judged(&self, hypothesis: &Hypothesis) -> bool {
        self.machine.before == 0 || hypothesis.since
    }

    /// `fit` with its last effect in runs from before as well, where it fits as well there.
    fn as_before(&self, fit: &Fit) -> Option<Fit> {
        let (last, others) = fit.hypotheses.split_last()?;
        if !last.since || last.counterpart(others).is_some() {
            return None;
        }
        let mut all = others.to_vec();
        all.push(Hypothesis {
            since: false,
            ..last.clone()
        });
        let begun = self.machine.begun(fit, all)?;
        let other = self.machine.fitted(begun, 3, 6);
        (other.deviance < fit.deviance + self.due(last)).then_some(other)
    }

    /// Of fits with one more effect than `fit`, those that bring at least `least` beyond what is due
    /// and half as much as the best, best first.
    fn leaders(&self, fit: &Fit, fits: Vec<Fit>, least: f64) -> Vec<Fit> {
        // among those that fit alike, lengths come before the sensor that measures with them
        let rank = |own: &Fit| {
            let of_sensor = own
                .hypotheses
                .last()
                .is_some_and(|h| h.info.id == "encoder_scale");
            let excess = self.excess(fit, own);
            if of_sensor {
                excess - FIRST_SUSPECT
            } else {
                excess
            }
        };
        let mut ranked: Vec<(f64, Fit)> = fits
            .into_iter()
            .filter(|own| self.excess(fit, own) > least && !self.is_tiny(&own.hypotheses))
            .map(|own| (rank(&own), own))
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = ranked.first().map_or(0.0, |(rank, _)| rank.max(0.0));
        let near = ranked.into_iter().filter(|(rank, _)| *rank >= 0.5 * best);
        near.take(POLISHED).map(|(_, own)| own).collect()
    }

    /// Fits all parameters and the noise, thresholds by trying others.
    fn refitted(&self, fit: Fit, rounds: usize, iterations: usize) -> Fit {
        let fit = if rounds > 2 && fit.hypotheses.last().is_some_and(Hypothesis::is_placed) {
            self.machine.settled_patch(fit)
        } else {
            fit
        };
        self.machine.fitted(fit, rounds, iterations)
    }

    /// What the last effect of `own` brings beyond what is due (−2 ln L).
    fn excess(&self, fit: &Fit, own: &Fit) -> f64 {
        let due = own.hypotheses.last().map_or(0.0, |h| self.due(h));
        fit.deviance - own.deviance - due
    }

    /// Whether the last effect is smaller than what integrators differ by.
    fn is_tiny(&self, hypotheses: &[Hypothesis]) -> bool {
        hypotheses.split_last().is_some_and(|(h, others)| {
            !h.is_abrupt()
                && h.values.iter().all(|(name, value)| {
                    let nothing = h.nothing_beside(&self.machine.model, name, others);
                    (value - nothing).abs() < TINY * least_change(h.info, name)
                })
        })
    }

    /// Whether the last effect is known to differ from nothing: by the model, and by blocks.
    fn is_clear(&self, fit: &Fit) -> bool {
        let Some((hypothesis, before)) = fit.hypotheses.split_last() else {
            return false;
        };
        if hypothesis.is_threshold() {
            return true;
        }
        if hypothesis.is_abrupt() {
            return !grips(hypothesis);
        }
        let Some(known) = self.machine.known(fit) else {
            return false;
        };
        let first = values(before).len();
        let then = hypothesis
            .counterpart(before)
            .map(|at| values(&before[..at]).len());
        let criterion = self.criterion(Some(&known));
        let strength = |covariance: &nalgebra::DMatrix<f64>| {
            hypothesis
                .values
                .iter()
                .enumerate()
                .filter(|(_, (name, _))| !is_where(hypothesis.info, name))
                .map(|(i, (name, value))| {
                    let off = value - hypothesis.nothing_beside(&self.machine.model, name, before);
                    let own = covariance[(first + i, first + i)];
                    let variance = then.map_or(own, |then| {
                        let [a, b] = [first + i, then + i];
                        own + covariance[(b, b)] - 2.0 * covariance[(a, b)]
                    });
                    off * off / variance.max(f64::MIN_POSITIVE)
                })
                .fold(0.0, f64::max)
        };
        strength(&known.model) > 2.0 * criterion.least_gain(1)
            && strength(&known.covariance) > criterion.alone().least_wald(1)
    }

    /// Whether the last effect of `own`, if it acts more than once, gains without its best block, or so
    /// much that a rare event is enough.
    fn is_lasting(&self, fit: &Fit, own: &Fit) -> bool {
        if own.hypotheses.last().is_none_or(Hypothesis::is_local) {
            return true;
        }
        let gains = self.gains_by_block(fit, own);
        let total: f64 = gains.iter().sum();
        total > CERTAIN || total - gains[0] > REST * total
    }

    /// What `own` gains over `fit` in each block, most first.
    fn gains_by_block(&self, fit: &Fit, own: &Fit) -> Vec<f64> {
        let (before, after) = (self.machine.by_block(fit), self.machine.by_block(own));
        let mut gains: Vec<f64> = before.iter().zip(&after).map(|(a, b)| a - b).collect();
        gains.sort_by(|a, b| b.total_cmp(a));
        gains
    }

    fn without(&self, fit: &Fit, at: usize) -> Option<Fit> {
        let mut fewer = fit.hypotheses.clone();
        fewer.remove(at);
        let begun = self.machine.begun_anew(fit, fewer)?;
        Some(self.machine.fitted(begun, 3, 6))
    }

    /// The fits without each effect.
    fn all_without(&self, fit: &Fit) -> Vec<Option<Fit>> {
        let all = 0..fit.hypotheses.len();
        all.into_par_iter()
            .map(|at| {
                let judged = self.is_judged(&fit.hypotheses[at]);
                judged.then(|| self.without(fit, at)).flatten()
            })
            .collect()
    }

    /// Without the effects that are not worth what is due beside the others; and the fits without each
    /// of those that stay.
    fn pruned(&self, mut fit: Fit) -> (Fit, Vec<Option<Fit>>) {
        loop {
            let less = self.all_without(&fit);
            let idle = less.iter().zip(&fit.hypotheses).position(|(less, own)| {
                let gain = less.as_ref().map(|less| less.deviance - fit.deviance);
                gain.is_some_and(|gain| gain < self.due(own)) || less.is_some() && grips(own)
            });
            match idle {
                Some(at) if fit.hypotheses.len() > 1 => match less.into_iter().nth(at).flatten() {
                    Some(next) => fit = next,
                    None => return (fit, Vec::new()),
                },
                _ => return (fit, less),
            }
        }
    }

    /// Each effect against the best in its place.
    fn swapped(
        &self,
        fit: Fit,
        less: Vec<Option<Fit>>,
        rivals: &mut Vec<(String, Vec<&'static str>)>,
    ) -> (Fit, Vec<Option<Fit>>) {
        if fit.hypotheses.len() < 2 {
            return (fit, less);
        }
        for (at, less) in less.iter().enumerate() {
            let Some(less) = less else { continue };
            let own = &fit.hypotheses[at];
            let id = own.info.id;
            let mut candidates = self.machine.screened(less, self.all);
            candidates.retain(|c| c.gain > GLANCE_GAIN && !c.hypothesis.is_like(own));
            candidates.truncate(2);
            for candidate in candidates {
                let begun = candidate.fit.or_else(|| {
                    self.machine
                        .begun(less, beside(less, &candidate.hypothesis))
                });
                let Some(other) = begun.map(|begun| self.machine.fitted(begun, 2, 6)) else {
                    continue;
                };
                let better =
                    other.deviance + self.due(&candidate.hypothesis) - fit.deviance - self.due(own);
                if better < -3.0 {
                    return self.pruned(other);
                } else if better < 2.0 * TIE_NATS {
                    let rival = candidate.hypothesis.info.id;
                    rivals.push((id.to_owned(), vec![rival]));
                }
            }
        }
        (fit, less)
    }

    /// What each effect brings (nats), and its rivals.
    fn weighed(
        &self,
        fit: &Fit,
        less: &[Option<Fit>],
        rivals: &[(String, Vec<&'static str>)],
    ) -> (Vec<f64>, Vec<Vec<&'static str>>) {
        let each = (0..fit.hypotheses.len()).map(|at| {
            let less = less.get(at).and_then(Option::as_ref);
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

/// Whether a wheel would not slip with such friction.
fn grips(hypothesis: &Hypothesis) -> bool {
    let kinetic = hypothesis.value(KINETIC);
    kinetic.is_some_and(|own| own >= GRIPS)
}
