//! The search for what is left out: the effects that together bring the residuals to noise.

use crate::bench::{Bench, FULL, Node, SPOILT};
use crate::force::{CHARGE, PULSE_S};
use crate::hypothesis::Hypothesis;
use crate::local;
use crate::located;
use crate::misfit::Misfit;
use crate::promise::Promise;
use crate::score;
use crate::unknown::{self, Beyond, Unknown};
use crate::wander::{Judge, Wander};

use crate::window::{AFTER_S, Window};
use std::cell::LazyCell;

use rayon::prelude::*;

/// Effects whose promise is followed a few rounds, and to the end.
const FOLLOWED: [usize; 2] = [9, 5];
/// Rounds of the first look.
const GLANCE: usize = 2;
/// Share of the gain of an effect that explains all that another has to promise, and to show at a
/// first look, to be fitted beside it.
const NEAR: f64 = 0.7;
const CLOSE: f64 = 0.95;
/// How long the end of a slide is looked for beyond the window that it began in (s).
const BEYOND_S: f64 = 0.6;
/// How much longer than in a model that is not yet right a patch may act, and how far around a push
/// a slide may reach that it stands for (s).
const EDGE_S: f64 = 0.5;
/// Share of the level at first below which an effect is on the way: no pairs are tried then.
const HALFWAY: f64 = 0.6;
/// Share of −2 ln L that an effect leaves of what was before where it is on the right way: nothing
/// else needs to be tried in its place.
const RIGHT_WAY: f64 = 0.15;
/// Share of −2 ln L that is much to promise, share of a promise below which it was not kept, and how
/// many of those are led there.
const MUCH: f64 = 0.1;
const KEPT: f64 = 0.3;
const UNKEPT: usize = 3;
/// Models that are kept side by side while none reaches the noise.
const SIDE_BY_SIDE: usize = 3;
/// Gain (−2 ln L) from which on a fit that goes on from elsewhere had not come to its end.
const UNFINISHED: f64 = 50.0;
/// How many times what is due an effect has to bring, to noise, to be certain without a parameter of
/// its own that is.
const CERTAIN: f64 = 10.0;
/// Effects at most.
const MOST: usize = 5;

/// Δ(−2 ln L) that one more effect has to bring, and for each parameter more.
const PAY: [f64; 2] = [24.0, 6.0];
/// Pushes at most: a force that acts again and again is no push.
const PUSHES: usize = 2;
/// The same for an effect whose place or time was searched.
const PAY_LOCAL: f64 = 40.0;
/// Share of the gain so far that one more effect has to bring where noise is reached: less is what
/// integrators differ by.
const SHARE: f64 = 0.02;
/// Δ(−2 ln L) that it has to bring on windows that its parameters were not fitted to: 2 ln of some
/// hundred tests over a hundredth.
pub(crate) const HELD_OUT: f64 = 18.0;
/// Δ(−2 ln L) within which two effects cannot be told apart.
const TWINS: f64 = 9.0;
/// Estimate over deviation that each effect has to keep in one of its parameters.
const SIGMAS: f64 = 4.2;

/// A model that explains the tracks as far as the catalogue can.
pub(crate) struct Found {
    pub(crate) nominal: Node,
    pub(crate) node: Node,
    /// Of each effect: ln L of all over all without it.
    pub(crate) gains: Vec<f64>,
    /// Of each effect: those that fit as well in its place.
    pub(crate) twins: Vec<Vec<&'static str>>,
    /// How many hypotheses were looked at.
    pub(crate) looked_at: usize,
    /// What the catalogue does not hold.
    pub(crate) unknown: Option<Unknown>,
    /// Forces without pattern, were there nothing else beside what the catalogue holds.
    pub(crate) wander: Option<Wander>,
}

/// What a search comes to.
pub(crate) enum Outcome {
    Found(Box<Found>),
    /// Wheels slide at these times (s), in which no window should begin, in a model with these
    /// effects.
    Slides(Vec<[f64; 2]>, Vec<Hypothesis>),
}

/// The search over one bench.
pub(crate) struct Search<'a> {
    pub(crate) bench: &'a Bench,
    pub(crate) all: Vec<Hypothesis>,
    pub(crate) excluded: &'a [String],
    /// Effects found before the windows were cut anew.
    pub(crate) known: Vec<Hypothesis>,
    /// Whether windows can be cut anew.
    pub(crate) cuts: bool,
    pub(crate) progress: &'a (dyn Fn(&str) + Sync),
}

fn deviance(node: &Node) -> f64 {
    node.fit.misfit.deviance()
}

/// −2 ln L with a charge for each parameter: what the search makes small.
fn score(node: &Node) -> f64 {
    deviance(node) + CHARGE * node.fit.values.len() as f64
}

/// What an effect has to bring.
fn due(hypothesis: &Hypothesis) -> f64 {
    let first = if hypothesis.is_local() {
        PAY_LOCAL
    } else {
        PAY[0]
    };
    first + PAY[1] * (hypothesis.values.len() as f64 - 1.0)
}

impl Search<'_> {
    /// Searches from the nominal model on. `None` if that cannot be simulated.
    pub(crate) fn run(&self) -> Option<Outcome> {
        (self.progress)("nominal model");
        let nominal = self
            .bench
            .fit(&[], &self.bench.guesses(&self.bench.windows)?, FULL)?;
        let nominal = self.bench.grown(nominal);
        if let Some(slides) = self.slides(&nominal) {
            return Some(Outcome::Slides(slides, Vec::new()));
        }
        Some(match self.combined(&nominal) {
            Ok((best, looked_at)) => {
                Outcome::Found(Box::new(self.concluded(nominal, best, looked_at)))
            }
            Err(slides) => slides,
        })
    }

    /// The effects that together explain most, and how many hypotheses were looked at; or when wheels
    /// slide in a model on the way, if windows begin there.
    fn combined(&self, nominal: &Node) -> Result<(Node, usize), Outcome> {
        let mut nodes = self.begun(nominal);
        let mut best = nodes[0].clone();
        let (mut looked_at, mut seen) = (0, Vec::new());
        for _ in 0..MOST {
            if self.is_done(nominal, &best) {
                break;
            }
            let next = self.next(nominal, &nodes, &mut seen, &mut looked_at);
            let settled = next.into_iter().map(|node| {
                let less = self.pruned(nominal, node);
                let grown = self.bench.settle_static(self.bench.grown(less));
                let placed = self.bench.settle_patch(grown);
                if self.bench.is_noise(&placed) {
                    placed
                } else {
                    self.bench.settle_threshold(placed)
                }
            });
            nodes = settled.filter(|node| !is_seen(&seen, node)).collect();
            nodes.sort_by(|a, b| score(a).total_cmp(&score(b)));
            let Some(first) = nodes.first() else { break };
            if let Some(slides) = self.slides(first) {
                return Err(Outcome::Slides(slides, first.hypotheses.clone()));
            }
            if score(first) < score(&best) {
                best = first.clone();
            }
        }
        Ok((best, looked_at))
    }

    /// Small forces without pattern beside `node`, if they explain all that it leaves.
    fn wandering(&self, node: &Node) -> Option<Wander> {
        if self.bench.is_noise(node) {
            return None;
        }
        let wander = Judge::new(self.bench, node)?.alone()?;
        wander.is_noise(self.bench).then_some(wander)
    }

    /// Where the search begins: at the nominal model, and at what was found before windows were cut
    /// anew.
    fn begun(&self, nominal: &Node) -> Vec<Node> {
        let known = (!self.known.is_empty()).then_some(&self.known);
        let known = known.and_then(|known| self.bench.fit(known, &nominal.fit.starts, FULL));
        let known = known.map(|node| self.pruned(nominal, self.bench.grown(node)));
        let known = known.map(|node| self.bench.settle_static(node));
        let better =
            |known: &Node| score(known) < score(nominal) && !self.bench.spoils(nominal, known);
        match known.filter(better) {
            Some(known) if self.bench.is_noise(&known) => vec![known],
            Some(known) => vec![known, nominal.clone()],
            None => vec![nominal.clone()],
        }
    }

    /// Whether so little is left that no further effect could bring its share.
    fn is_done(&self, nominal: &Node, node: &Node) -> bool {
        let so_far = node.fit.misfit.gain_over(&nominal.fit.misfit);
        self.bench.is_noise(node) && deviance(node) < (SHARE * so_far).max(PAY[0])
    }

    /// Whether `next` explains all, or nearly all that `node` leaves.
    fn is_right(&self, node: &Node, next: &Node) -> bool {
        self.bench.is_all(next) || deviance(next) < RIGHT_WAY * deviance(node)
    }

    /// The nodes with one more effect each, best first, as many as are kept side by side.
    fn next(
        &self,
        nominal: &Node,
        nodes: &[Node],
        seen: &mut Vec<Node>,
        looked_at: &mut usize,
    ) -> Vec<Node> {
        let mut next: Vec<Node> = Vec::new();
        for (rank, node) in nodes.iter().enumerate() {
            if is_seen(seen, node) {
                continue;
            }
            seen.push(node.clone());
            let candidates = self.candidates(node);
            *looked_at += candidates.len();
            next.extend(self.extended(nominal, node, &candidates, rank == 0));
            // the best comes first: what lies further back could hardly explain more
            if next.iter().any(|next| self.is_right(node, next)) {
                break;
            }
        }
        let far = HALFWAY * self.bench.worst(nominal).1;
        let near = |n: &Node| self.bench.is_noise(n) || self.bench.worst(n).1 < far;
        if seen.len() == 1 && !next.iter().any(near) && self.wandering(nominal).is_none() {
            next.extend(self.beside_slip(nominal));
        }
        next.sort_by(|a, b| score(a).total_cmp(&score(b)));
        let mut kept: Vec<Node> = Vec::new();
        for node in next {
            if !kept.iter().any(|known| same(known, &node)) {
                kept.push(node);
            }
        }
        let enough = kept.first().is_some_and(|first| self.bench.is_noise(first));
        kept.truncate(if enough { 1 } else { SIDE_BY_SIDE });
        kept
    }

    /// What was found, weighed, and what the catalogue does not hold.
    fn concluded(&self, nominal: Node, best: Node, looked_at: usize) -> Found {
        if self.bench.is_noise(&best) {
            return self.weighed(nominal, best, looked_at);
        }
        (self.progress)("forces outside of the catalogue");
        let mut best = if self.holds(&best) {
            best
        } else {
            nominal.clone()
        };
        let mut beside = unknown::beside(self.bench, &best);
        for fewer in [self.without_pushes(&best), Some(nominal.clone())] {
            let Some(fewer) = fewer.filter(|f| f.hypotheses.len() < best.hypotheses.len()) else {
                continue;
            };
            // what explains more by itself than all that was found needs none of it; and pushes that
            // do not explain all may be pieces of it
            let gone = |h: &Hypothesis| !fewer.hypotheses.iter().any(|kept| kept.is_like(h));
            let mut without = best.hypotheses.iter().filter(|h| gone(h));
            let pieces = without.all(|h| h.info.id == "push");
            let likelier = |alone: &Beyond| {
                beside.as_ref().is_some_and(|beside| {
                    let pieces = pieces && beside.is_of_moments();
                    alone.score < beside.score || alone.unknown.is_some() && pieces
                })
            };
            let alone = unknown::beside(self.bench, &fewer);
            if let Some(alone) = alone.filter(likelier) {
                (best, beside) = (fewer, Some(alone));
            }
        }
        let mut found = self.weighed(nominal, best, looked_at);
        if let Some(beyond) = beside.filter(|_| !self.bench.is_noise(&found.node)) {
            found.unknown = beyond.unknown;
            found.wander = Some(beyond.wander);
        }
        found
    }

    /// Whether the effects of a node, fitted to every other window, predict the rest no worse than the
    /// nominal model does.
    fn holds(&self, node: &Node) -> bool {
        let bench = self.bench;
        let total = |misfit: &Misfit| score::total(misfit).unwrap_or(0.0);
        let before = total(&score::prediction(bench, &bench.windows, &[]));
        let after = score::held_out(bench, &bench.windows, &node.hypotheses);
        node.hypotheses.is_empty() || total(&after) < SPOILT * before
    }

    /// The node without its pushes, if it has any.
    fn without_pushes(&self, node: &Node) -> Option<Node> {
        let lasting = node.hypotheses.iter().filter(|h| h.info.id != "push");
        let lasting: Vec<Hypothesis> = lasting.cloned().collect();
        if lasting.len() == node.hypotheses.len() {
            return None;
        }
        self.bench.fit(&lasting, &node.fit.starts, FULL)
    }

    /// When the wheels slide in a model that slips and does not yet reach the noise, or its gears are
    /// apart, if a window begins there, unless that is known already. A push that explains all where a
    /// window begins may be such a slide.
    fn slides(&self, node: &Node) -> Option<Vec<[f64; 2]>> {
        if !self.cuts {
            return None;
        }
        let noise = self.bench.is_noise(node);
        if !noise && has(node, "backlash") {
            return Some(located::apart(self.bench)).filter(|apart| self.begins_in(apart));
        }
        if !self.slips(node) {
            return None;
        }
        let pushes = noise.then(|| self.begun_by_push(node));
        let mut slides = pushes.unwrap_or_default();
        if noise && slides.is_empty() {
            return None;
        }
        let of_model = located::sliding(self.bench, node, None, BEYOND_S);
        // where a patch ends is not known well while a window begins on it
        let edge_s = if has(node, "friction_patch") {
            EDGE_S
        } else {
            0.0
        };
        slides.extend(
            of_model
                .iter()
                .map(|[from, to]| [from - edge_s, to + edge_s]),
        );
        self.begins_in(&slides).then_some(slides)
    }

    /// Whether a window begins at one of these times (s).
    fn begins_in(&self, times_s: &[[f64; 2]]) -> bool {
        let begins = |window: &Window| {
            let mut times_s = times_s.iter();
            times_s.any(|[from, to]| window.from_s > *from && window.from_s < to + AFTER_S)
        };
        self.bench.windows.iter().any(begins)
    }

    /// Around the pushes with which a window begins, other than the first.
    fn begun_by_push(&self, node: &Node) -> Vec<[f64; 2]> {
        let pushes = node.hypotheses.iter().filter(|h| h.info.id == "push");
        let begins = |t_s: &f64| {
            let mut later = self.bench.windows.windows(2).map(|pair| pair[1].from_s);
            later.any(|from_s| (from_s - t_s).abs() < PULSE_S)
        };
        let times_s = pushes.map(|push| push.values[0].1).filter(begins);
        times_s.map(|t_s| [t_s - EDGE_S, t_s + EDGE_S]).collect()
    }

    /// Whether wheels may slide in a model.
    fn slips(&self, node: &Node) -> bool {
        let mut found = node.hypotheses.iter();
        let mut known = self.bench.model.effects.iter();
        found.any(|h| matches!(h.info.id, "wheel_slip" | "friction_patch"))
            || known.any(|e| e.effect == "wheel_slip")
    }

    fn candidates(&self, node: &Node) -> Vec<Hypothesis> {
        let taken = |h: &Hypothesis| {
            let known = |k: &Hypothesis| k.is_like(h) && !h.is_local();
            node.hypotheses.iter().any(known)
        };
        self.all.iter().filter(|h| !taken(h)).cloned().collect()
    }

    /// The extensions by one effect that pay, best first.
    fn extended(
        &self,
        nominal: &Node,
        node: &Node,
        candidates: &[Hypothesis],
        locally: bool,
    ) -> Vec<Node> {
        let ids: Vec<&str> = node.hypotheses.iter().map(|h| h.info.id).collect();
        (self.progress)(&format!(
            "{} effects beside [{}]",
            candidates.len(),
            ids.join(", ")
        ));
        let mut followed = self.followed(node, candidates, 0.5 * PAY[0]);
        let enough = |next: &Node| self.bench.is_noise(next) || self.is_right(node, next);
        if locally && !followed.iter().any(enough) {
            let local = local::candidates(self.bench, node, self.excluded);
            followed.extend(self.followed(node, &local, 0.5 * PAY[0]));
        }
        let freed = self.freed(node, &followed);
        let wander = LazyCell::new(|| self.wandering(node));
        followed.retain(|next| self.pays(nominal, node, next, &wander));
        followed.extend(freed);
        followed
    }

    /// The node itself from where a further effect that is none led it: a fit that had not come to
    /// its end.
    fn freed(&self, node: &Node, followed: &[Node]) -> Option<Node> {
        let best = followed.first()?;
        let own = best.hypotheses.len().checked_sub(1)?;
        if own == 0 || self.is_clear(best, own) || score(best) > score(node) - UNFINISHED {
            return None;
        }
        let freed = self
            .bench
            .fit(&best.hypotheses[..own], &best.fit.starts, FULL)?;
        (score(&freed) < score(node) - UNFINISHED).then_some(freed)
    }

    /// Slip together with one other effect: alone it may fit worse than nothing, because each slide
    /// begins where the other effect lets it.
    fn beside_slip(&self, nominal: &Node) -> Vec<Node> {
        if self.bench.is_noise(nominal) {
            return Vec::new();
        }
        (self.progress)("effects beside slip");
        let slips = self
            .all
            .par_iter()
            .filter(|h| h.info.id == "wheel_slip" && h.replaces.is_none());
        let slips = slips.filter_map(|h| {
            self.bench
                .fit(std::slice::from_ref(h), &nominal.fit.starts, GLANCE)
        });
        let mut slips: Vec<Node> = slips.collect();
        slips.sort_by(|a, b| score(a).total_cmp(&score(b)));
        slips.truncate(SIDE_BY_SIDE);
        let mut pairs: Vec<(usize, Promise)> = Vec::new();
        for (i, slip) in slips.iter().enumerate() {
            let mut one_each: Vec<Hypothesis> = Vec::new();
            for candidate in self.candidates(slip) {
                if !one_each.iter().any(|known| known.is_like(&candidate)) {
                    one_each.push(candidate);
                }
            }
            let promises = self.bench.promises(slip, &one_each);
            pairs.extend(promises.into_iter().take(FOLLOWED[1]).map(|p| (i, p)));
        }
        pairs.sort_by(|a, b| a.1.deviance.total_cmp(&b.1.deviance));
        pairs.truncate(FOLLOWED[0]);
        let glances = pairs
            .par_iter()
            .filter_map(|(i, p)| self.bench.follow(&slips[*i], p, GLANCE));
        let mut glances: Vec<Node> = glances.collect();
        glances.sort_by(|a, b| score(a).total_cmp(&score(b)));
        glances.truncate(SIDE_BY_SIDE);
        let full = glances
            .par_iter()
            .filter_map(|glance| self.bench.fit(&glance.hypotheses, &glance.fit.starts, FULL));
        let mut full: Vec<Node> = full.collect();
        full.sort_by(|a, b| score(a).total_cmp(&score(b)));
        if let Some(first) = full.first_mut() {
            *first = self.bench.settle_static(first.clone());
        }
        full.retain(|node| deviance(node) < deviance(nominal));
        full
    }

    /// The most promising extensions, fitted to the end.
    fn followed(&self, node: &Node, candidates: &[Hypothesis], least: f64) -> Vec<Node> {
        let promises = self.bench.promises(node, candidates);
        let before = deviance(node);
        let mut chosen: Vec<&Promise> = Vec::new();
        for promise in promises.iter().filter(|p| before - p.deviance > least) {
            let known = |c: &&Promise| c.hypothesis.is_like(&promise.hypothesis);
            // of what has several places or sizes, the best two
            if chosen.iter().filter(|c| known(c)).count() < 2 {
                chosen.push(promise);
            }
        }
        chosen.truncate(FOLLOWED[0]);
        let Some(best) = chosen
            .first()
            .and_then(|p| self.bench.follow(node, p, GLANCE))
        else {
            return Vec::new();
        };
        // where one explains all, only what promises nearly as much is worth a fit
        let near = before - NEAR * (before - deviance(&best));
        let worth = |p: &&&Promise| !self.bench.is_noise(&best) || p.deviance < near;
        let rest: Vec<&Promise> = chosen[1..].iter().filter(worth).copied().collect();
        let glances = rest
            .par_iter()
            .filter_map(|p| self.bench.follow(node, p, GLANCE));
        let mut glances: Vec<Node> = glances.collect();
        glances.push(best);
        if !glances.iter().any(|glance| self.is_right(node, glance)) {
            glances.extend(self.unkept(node, &chosen, &glances));
        }
        glances.sort_by(|a, b| score(a).total_cmp(&score(b)));
        let first = deviance(&glances[0]);
        if self.bench.is_noise(&glances[0]) {
            let least = (before - CLOSE * (before - first)).max(first + 60.0);
            glances.retain(|glance| deviance(glance) < least);
        }
        let mut different: Vec<Node> = Vec::new();
        for glance in glances {
            let twin = |known: &Node| {
                let own = |node: &Node| node.hypotheses.last().cloned();
                let like = own(known)
                    .zip(own(&glance))
                    .is_some_and(|(a, b)| a.is_like(&b));
                like && (deviance(known) - deviance(&glance)).abs() < 1.0
            };
            if !different.iter().any(twin) {
                different.push(glance);
            }
        }
        different.truncate(FOLLOWED[1]);
        let full = different.par_iter().filter_map(|glance| {
            let full = self
                .bench
                .fit(&glance.hypotheses, &glance.fit.starts, FULL)?;
            let slips = full
                .hypotheses
                .last()
                .is_some_and(|h| h.info.id == "wheel_slip");
            Some(if slips {
                self.bench.settle_static(full)
            } else {
                full
            })
        });
        let mut full: Vec<Node> = full.collect();
        full.sort_by(|a, b| score(a).total_cmp(&score(b)));
        full
    }

    /// What promised much and did not keep it, fitted over ever longer heads of the windows: where
    /// residuals are large, the way there is no matter of first order.
    fn unkept(&self, node: &Node, promises: &[&Promise], glances: &[Node]) -> Vec<Node> {
        let before = deviance(node);
        let kept = |promise: &Promise| {
            let own = |glance: &&Node| {
                let last = glance.hypotheses.last();
                last.is_some_and(|own| own.is_like(&promise.hypothesis))
            };
            let all = glances.iter().filter(own);
            all.map(|glance| before - deviance(glance))
                .fold(0.0, f64::max)
        };
        let unkept = promises.iter().filter(|promise| {
            let promised = before - promise.deviance;
            promised > MUCH * before && kept(promise) < KEPT * promised
        });
        let unkept: Vec<&Promise> = unkept.take(UNKEPT).copied().collect();
        let led = unkept.par_iter().filter_map(|promise| {
            let mut hypotheses = node.hypotheses.clone();
            hypotheses.push(promise.hypothesis.clone());
            self.bench.led(&hypotheses)
        });
        led.collect()
    }

    fn pays(
        &self,
        nominal: &Node,
        before: &Node,
        after: &Node,
        wander: &LazyCell<Option<Wander>, impl FnOnce() -> Option<Wander>>,
    ) -> bool {
        let Some(own) = after.hypotheses.last() else {
            return false;
        };
        let gain = after.fit.misfit.gain_over(&before.fit.misfit);
        let so_far = before.fit.misfit.gain_over(&nominal.fit.misfit);
        if self.bench.is_noise(before) && gain < SHARE * so_far {
            return false;
        }
        let last = after.hypotheses.len() - 1;
        let brings =
            self.bench.is_noise(after) && gain > CERTAIN * due(own) && self.may(after, last);
        if gain <= due(own)
            || !(brings || self.is_clear(after, last))
            || self.bench.spoils(before, after)
        {
            return false;
        }
        let certain = gain > CERTAIN * due(own) || !self.slips(after);
        if self.bench.is_noise(after) && (certain || own.is_local()) {
            return true;
        }
        if let Some(wander) = LazyCell::force(wander) {
            return self.is_likelier(wander, after, due(own));
        }
        // what repeats in every fit may be a part of something else, or how simulators differ in a
        // single slide
        let proven = own.is_local() || self.bench.windows.len() < 4;
        proven || self.bench.held_out_gain(before, after) > HELD_OUT
    }

    /// Whether `node` brings more than `due` over forces without pattern in its place.
    fn is_likelier(&self, wander: &Wander, node: &Node, due: f64) -> bool {
        let beside = Judge::new(self.bench, node).and_then(|judge| judge.alone());
        beside.is_some_and(|beside| beside.deviance < wander.deviance - due)
    }

    /// Whether an effect is within its bounds, and no push too many.
    fn may(&self, node: &Node, which: usize) -> bool {
        let pushes = node.hypotheses.iter().filter(|h| h.info.id == "push");
        !node.hypotheses[which].is_at_bound() && pushes.count() <= PUSHES
    }

    /// Whether an effect differs from nothing by its own uncertainty.
    fn is_clear(&self, node: &Node, which: usize) -> bool {
        let fitted = |h: &Hypothesis| if h.is_threshold() { 0 } else { h.values.len() };
        let first: usize = node.hypotheses[..which].iter().map(fitted).sum();
        let own = &node.hypotheses[which];
        if !self.may(node, which) {
            return false;
        }
        own.is_threshold()
            || own.values.iter().enumerate().any(|(i, (name, value))| {
                let nothing = own.nothing(&self.bench.model, name);
                (value - nothing).abs() > SIGMAS * node.fit.deviations[first + i]
            })
    }

    /// Takes out what no longer pays beside what came later.
    fn pruned(&self, nominal: &Node, mut node: Node) -> Node {
        let share = SHARE * node.fit.misfit.gain_over(&nominal.fit.misfit);
        let mut at = 0;
        while node.hypotheses.len() > 1 && at < node.hypotheses.len() {
            let mut without = node.hypotheses.clone();
            let removed = without.remove(at);
            (self.progress)(&format!("without {}", removed.info.id));
            let less = self.bench.fit(&without, &node.fit.starts, FULL);
            let idle = |less: &Node| {
                let gain = node.fit.misfit.gain_over(&less.fit.misfit);
                let wander = || self.wandering(less).filter(|_| !self.bench.is_noise(&node));
                gain < due(&removed)
                    || self.bench.is_noise(less) && gain < share
                    || wander().is_some_and(|w| !self.is_likelier(&w, &node, due(&removed)))
            };
            match less.filter(idle) {
                Some(less) => (node, at) = (less, 0),
                None => at += 1,
            }
        }
        node
    }

    /// What each effect brings, and what could stand in its place. What fits better in its place
    /// takes it.
    fn weighed(&self, nominal: Node, mut node: Node, looked_at: usize) -> Found {
        let (mut gains, mut twins) = (Vec::new(), Vec::new());
        let mut swaps = 0;
        let mut at = 0;
        while at < node.hypotheses.len() {
            let mut without = node.hypotheses.clone();
            let removed = without.remove(at);
            (self.progress)(&format!("what {} brings", removed.info.id));
            let Some(less) = self.bench.fit(&without, &node.fit.starts, FULL) else {
                gains.push(0.0);
                twins.push(Vec::new());
                at += 1;
                continue;
            };
            let candidates: Vec<Hypothesis> = self
                .candidates(&less)
                .into_iter()
                .filter(|h| !h.is_like(&removed) && !node.hypotheses.iter().any(|k| k.is_like(h)))
                .collect();
            let rivals = self.followed(
                &less,
                &candidates,
                0.5 * (deviance(&less) - deviance(&node)),
            );
            if let Some(rival) = rivals
                .iter()
                .find(|r| self.is_clear(r, r.hypotheses.len() - 1) && !self.bench.spoils(&node, r))
                && score(rival) < score(&node) - 3.0
                && swaps < 3
            {
                node = rival.clone();
                (gains, twins, at) = (Vec::new(), Vec::new(), 0);
                swaps += 1;
                continue;
            }
            gains.push((deviance(&less) - deviance(&node)) / 2.0);
            let near = rivals
                .iter()
                .filter(|r| deviance(r) < deviance(&node) + TWINS);
            let mut ids: Vec<&'static str> = near
                .filter_map(|r| Some(r.hypotheses.last()?.info.id))
                .collect();
            ids.sort_unstable();
            ids.dedup();
            ids.retain(|id| *id != removed.info.id);
            twins.push(ids);
            at += 1;
        }
        Found {
            nominal,
            node,
            gains,
            twins,
            looked_at,
            unknown: None,
            wander: None,
        }
    }
}

/// Whether an effect is among those of a node.
fn has(node: &Node, id: &str) -> bool {
    node.hypotheses.iter().any(|h| h.info.id == id)
}

/// Whether the same effects were looked at before and fitted no worse.
fn is_seen(seen: &[Node], node: &Node) -> bool {
    let mut seen = seen.iter();
    seen.any(|known| same(known, node) && score(known) < score(node) + 1.0)
}

fn same(a: &Node, b: &Node) -> bool {
    let key = |node: &Node| {
        let mut ids: Vec<_> = node
            .hypotheses
            .iter()
            .map(|h| (h.info.id, h.text, h.only))
            .collect();
        ids.sort_unstable();
        ids
    };
    key(a) == key(b)
}
