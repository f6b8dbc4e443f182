//! From what effects promise to what they keep.

use rayon::prelude::*;
use slipstream_sim::effects::When;

use crate::windows::bench::{FULL, HELD_OUT, Node};
use crate::windows::hypothesis::Hypothesis;
use crate::windows::promise::Promise;
use crate::windows::search::{SIDE_BY_SIDE, Search, best_first, deviance};

/// Effects whose promise is followed a few rounds, and to the end.
pub(crate) const FOLLOWED: [usize; 2] = [9, 5];
/// Rounds of the first look.
pub(crate) const GLANCE: usize = 2;
/// Rounds of a second look, and how much more (−2 ln L, share of the best) what is then fitted to the
/// end may leave, beside the best few.
pub(crate) const LOOK: usize = 6;
const BEHIND: f64 = 1.2;
/// Share of the gain of an effect that explains all that another has to promise, and to show at a
/// first look, to be fitted beside it.
const NEAR: f64 = 0.7;
const CLOSE: f64 = 0.95;
/// Gain (−2 ln L) within which one that explains all has rivals, whatever its own.
const BESIDE: f64 = 60.0;
/// Share of −2 ln L that is much to promise, share of a promise below which it was not kept, and how
/// many of those are led there.
const MUCH: f64 = 0.1;
const KEPT: f64 = 0.3;
const UNKEPT: usize = 3;
/// Level of the worst channel (deviations) from which on a model is so far off that what it lacks may
/// show over the heads of windows alone, and their length (s) there.
const FAR_OFF: f64 = 30.0;
const NEAR_S: f64 = 1.0;

impl Search<'_> {
    /// The most promising extensions, fitted to the end.
    pub(crate) fn followed(&self, node: &Node, candidates: &[Hypothesis], least: f64) -> Vec<Node> {
        let promises = self.bench.promises(node, candidates);
        let before = deviance(node);
        let promises = promises.iter().filter(|p| before - p.deviance > least);
        let chosen = chosen(promises, 2);
        let mut glances = distinct(self.glances(node, &chosen, candidates));
        glances.truncate(FOLLOWED[1]);
        let looks = self.looks(&glances);
        let full = looks.par_iter().filter_map(|look| {
            let full = self.bench.fit(&look.hypotheses, &look.fit.starts, FULL)?;
            let own = full.hypotheses.last();
            Some(if own.is_some_and(|h| h.info.acts == When::Sliding) {
                self.bench.settle_static(full)
            } else {
                full
            })
        });
        let mut full: Vec<Node> = full.collect();
        best_first(&mut full);
        full
    }

    /// A second look at what the first one left, best first: without what is far behind.
    fn looks(&self, glances: &[Node]) -> Vec<Node> {
        if glances.len() <= SIDE_BY_SIDE {
            return glances.to_vec();
        }
        let look = |glance: &Node| self.bench.fit(&glance.hypotheses, &glance.fit.starts, LOOK);
        let mut looks: Vec<Node> = glances.par_iter().filter_map(look).collect();
        best_first(&mut looks);
        let far = looks
            .first()
            .map_or(0.0, |best| BEHIND * deviance(best) + BESIDE);
        let kept = looks.into_iter().enumerate();
        let kept = kept.filter(|(rank, look)| *rank < SIDE_BY_SIDE || deviance(look) < far);
        kept.map(|(_, look)| look).collect()
    }

    /// A first look at promises, best first: where one explains all, only at what promises nearly as
    /// much.
    fn glances(&self, node: &Node, chosen: &[&Promise], candidates: &[Hypothesis]) -> Vec<Node> {
        let before = deviance(node);
        let glance = |promise: &Promise| self.bench.follow(node, promise, GLANCE);
        let Some(best) = chosen.first().and_then(|first| glance(first)) else {
            return Vec::new();
        };
        let near = before - NEAR * (before - deviance(&best));
        let worth = |p: &&&Promise| !self.bench.is_noise(&best) || p.deviance < near;
        let rest: Vec<&Promise> = chosen[1..].iter().filter(worth).copied().collect();
        let mut glances: Vec<Node> = rest.par_iter().filter_map(|p| glance(p)).collect();
        glances.push(best);
        if !glances.iter().any(|glance| self.is_right(node, glance)) {
            glances.extend(self.unkept(node, chosen, &glances));
            if self.bench.worst(node).1 > FAR_OFF {
                glances.extend(self.near(node, candidates));
            }
        }
        best_first(&mut glances);
        let first = deviance(&glances[0]);
        if self.bench.is_noise(&glances[0]) {
            let least = (before - CLOSE * (before - first)).max(first + BESIDE);
            glances.retain(|glance| deviance(glance) < least);
        }
        glances
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
        self.led(node, &unkept)
    }

    /// What promises most over the heads of the windows, led from there over ever longer ones: what is
    /// far off after seconds may be a matter of first order before.
    fn near(&self, node: &Node, candidates: &[Hypothesis]) -> Vec<Node> {
        let heads = self.bench.over(self.bench.heads(NEAR_S));
        let Some(begun) = heads.fit(&node.hypotheses, &node.fit.starts, HELD_OUT) else {
            return Vec::new();
        };
        let lasting: Vec<Hypothesis> = candidates
            .iter()
            .filter(|h| !h.is_local())
            .cloned()
            .collect();
        let promises = heads.promises(&begun, &lasting);
        let mut best = chosen(promises.iter(), 1);
        best.truncate(UNKEPT);
        self.led(node, &best)
    }

    /// `node` with each of what was promised, led there over ever longer heads of the windows.
    fn led(&self, node: &Node, promises: &[&Promise]) -> Vec<Node> {
        let led = promises.par_iter().filter_map(|promise| {
            let mut hypotheses = node.hypotheses.clone();
            hypotheses.push(promise.hypothesis.clone());
            self.bench.led(&hypotheses)
        });
        led.collect()
    }
}

/// The best promises; of what has several places or sizes, the best `each`.
fn chosen<'a>(promises: impl Iterator<Item = &'a Promise>, each: usize) -> Vec<&'a Promise> {
    let mut chosen: Vec<&Promise> = Vec::new();
    for promise in promises {
        let known = |c: &&&Promise| c.hypothesis.is_like(&promise.hypothesis);
        if chosen.iter().filter(known).count() < each {
            chosen.push(promise);
        }
    }
    chosen.truncate(FOLLOWED[0]);
    chosen
}

/// Without those that came to the same effect as an earlier one, fitted as well.
fn distinct(glances: Vec<Node>) -> Vec<Node> {
    let mut distinct: Vec<Node> = Vec::new();
    for glance in glances {
        let twin = |known: &Node| {
            let own = |node: &Node| node.hypotheses.last().cloned();
            let pair = own(known).zip(own(&glance));
            let like = pair.is_some_and(|(a, b)| a.is_like(&b));
            like && (deviance(known) - deviance(&glance)).abs() < 1.0
        };
        if !distinct.iter().any(twin) {
            distinct.push(glance);
        }
    }
    distinct
}
