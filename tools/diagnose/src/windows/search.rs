//! The search for what is left out: the effects that together bring the residuals to noise.

use std::cell::LazyCell;
use std::slice;

use rayon::prelude::*;

use crate::windows::bench::{Bench, FULL, Node};
use crate::windows::follow::{FOLLOWED, GLANCE};
use crate::windows::force::CHARGE;
use crate::windows::hypothesis::Hypothesis;
use crate::windows::local;
use crate::windows::pay::{PAY, SIGMAS};
use crate::windows::promise::Promise;
use crate::windows::weigh::Found;

/// Share of the level at first below which an effect is on the way: no pairs are tried then.
const HALFWAY: f64 = 0.6;
/// Share of −2 ln L that an effect leaves of what was before where it is on the right way: nothing
/// else needs to be tried in its place.
const RIGHT_WAY: f64 = 0.15;
/// Effects that do not pay alone beside which a second one is looked for, where nothing pays.
const STONES: usize = 2;
/// Frictions at which slip is tried together with another effect.
const SLIPS: usize = 8;
/// Models that are kept side by side while none reaches the noise.
pub(crate) const SIDE_BY_SIDE: usize = 3;
/// Gain (−2 ln L) from which on a fit that goes on from elsewhere had not come to its end.
const UNFINISHED: f64 = 50.0;
/// Share of −2 ln L that a round leaves where the search gets on no more.
const STALLED: f64 = 0.5;
/// Effects at most.
const MOST: usize = 5;

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

pub(crate) fn deviance(node: &Node) -> f64 {
    node.fit.misfit.deviance()
}

/// −2 ln L with a charge for each parameter: what the search makes small.
pub(crate) fn score(node: &Node) -> f64 {
    deviance(node) + CHARGE * node.fit.values.len() as f64
}

/// Sorts nodes by what the search makes small.
pub(crate) fn best_first(nodes: &mut [Node]) {
    nodes.sort_by(|a, b| score(a).total_cmp(&score(b)));
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
            return Some(Outcome::Slides(slides, self.known.clone()));
        }
        Some(match self.combined(&nominal) {
            Ok((best, looked_at)) => {
                let stopped = self.bench.is_spent() && !self.bench.is_noise(&best);
                let found = self.concluded(nominal, best, looked_at);
                Outcome::Found(Box::new(Found { stopped, ..found }))
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
        let mut before = f64::INFINITY;
        for _ in 0..MOST {
            // a search that is getting on is not stopped
            let stalls = deviance(&best) > STALLED * before;
            if self.is_done(nominal, &best) || stalls && self.bench.is_spent() {
                break;
            }
            before = deviance(&best);
            let next = self.next(nominal, &nodes, &mut seen, &mut looked_at);
            let settled = next.into_iter().map(|node| {
                let less = self.pruned(nominal, node);
                self.bench.settled(less)
            });
            nodes = settled.filter(|node| !is_seen(&seen, node)).collect();
            best_first(&mut nodes);
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

    /// Where the search begins: at the nominal model, and at what was found before windows were cut
    /// anew.
    fn begun(&self, nominal: &Node) -> Vec<Node> {
        let known = (!self.known.is_empty()).then_some(&self.known);
        let known = known.and_then(|known| self.bench.fit(known, &nominal.fit.starts, FULL));
        let known = known.map(|node| self.pruned(nominal, self.bench.grown(node)));
        let known = known.map(|node| self.bench.settle_gap(self.bench.settle_static(node)));
        let better =
            |known: &Node| score(known) < score(nominal) && !self.bench.spoils(nominal, known);
        match known.filter(better) {
            Some(known) if self.bench.is_noise(&known) => vec![known],
            Some(known) => vec![known, nominal.clone()],
            None => vec![nominal.clone()],
        }
    }

    /// Whether `next` explains all, or nearly all that `node` leaves.
    pub(crate) fn is_right(&self, node: &Node, next: &Node) -> bool {
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
            // the best comes first: what lies further back could hardly explain more, unless the best
            // leads nowhere
            let leads_on = !next.is_empty() || self.bench.is_spent();
            if next.iter().any(|next| self.is_right(node, next))
                || leads_on && self.bench.is_narrow()
            {
                break;
            }
        }
        let far = HALFWAY * self.bench.worst(nominal).1;
        let near = |n: &Node| self.bench.is_noise(n) || self.bench.worst(n).1 < far;
        if seen.len() == 1 && !next.iter().any(near) && self.wandering(nominal).is_none() {
            next.extend(self.beside_slip(nominal));
        }
        best_first(&mut next);
        let mut kept: Vec<Node> = Vec::new();
        for node in next {
            if !kept.iter().any(|known| same(known, &node)) {
                kept.push(node);
            }
        }
        let enough = kept.first().is_some_and(|first| self.bench.is_noise(first));
        let alone = enough || self.bench.is_narrow();
        kept.truncate(if alone { 1 } else { SIDE_BY_SIDE });
        kept
    }

    pub(crate) fn candidates(&self, node: &Node) -> Vec<Hypothesis> {
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
        best_first(&mut followed);
        let freed = self.freed(node, &followed);
        let beside = LazyCell::new(|| self.wandering(node));
        let stones: Vec<Node> = followed.iter().take(STONES).cloned().collect();
        followed.retain(|next| self.pays(nominal, node, next, &beside));
        followed.extend(freed);
        if followed.is_empty() && !self.bench.is_noise(node) {
            return self.beyond(node, &stones);
        }
        followed
    }

    /// Two effects that do not pay alone, and together leave next to nothing. A search that has cost
    /// much does not look for them.
    fn beyond(&self, node: &Node, stones: &[Node]) -> Vec<Node> {
        let stones = stones.iter().take_while(|_| !self.bench.is_narrow());
        let pairs = stones.map(|stone| {
            let mut pairs = self.followed(stone, &self.candidates(stone), 0.5 * PAY[0]);
            pairs.retain(|pair| self.is_right(node, pair));
            pairs
        });
        let mut pairs = pairs.filter(|pairs| !pairs.is_empty());
        pairs.next().unwrap_or_default()
    }

    /// The node itself from where a further effect that is none led it: a fit that had not come to
    /// its end.
    fn freed(&self, node: &Node, followed: &[Node]) -> Option<Node> {
        let best = followed.first()?;
        let own = best.hypotheses.len().checked_sub(1)?;
        if own == 0 || self.is_clear(best, own, SIGMAS) || score(best) > score(node) - UNFINISHED {
            return None;
        }
        let freed = self
            .bench
            .fit(&best.hypotheses[..own], &best.fit.starts, FULL)?;
        let better = score(&freed) < score(node) - UNFINISHED;
        (better && !self.bench.spoils(node, &freed)).then_some(freed)
    }

    /// Slip at some frictions, from the largest on at which something slides.
    fn sliding(&self, nominal: &Node) -> Vec<Hypothesis> {
        let slips = self.all.par_iter().filter(|h| h.is_abrupt());
        let begun =
            slips.filter_map(|h| Some((h, self.bench.started(nominal, slice::from_ref(h))?)));
        let begun: Vec<(&Hypothesis, f64)> = begun.collect();
        let rolls = |(_, begun): &&(&Hypothesis, f64)| (begun - deviance(nominal)).abs() < 1.0;
        let sliding = begun.iter().skip_while(rolls).step_by(2).take(SLIPS);
        sliding.map(|(h, _)| (*h).clone()).collect()
    }

    /// Slip together with one other effect: alone it may fit worse than nothing, because each slide
    /// begins where the other effect lets it.
    fn beside_slip(&self, nominal: &Node) -> Vec<Node> {
        if self.bench.is_noise(nominal) {
            return Vec::new();
        }
        (self.progress)("effects beside slip");
        let slips = self.sliding(nominal);
        let glance = |h: &Hypothesis| {
            self.bench
                .fit(slice::from_ref(h), &nominal.fit.starts, GLANCE)
        };
        let mut slips: Vec<Node> = slips.par_iter().filter_map(glance).collect();
        best_first(&mut slips);
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
        best_first(&mut glances);
        glances.truncate(SIDE_BY_SIDE);
        let full = glances
            .par_iter()
            .filter_map(|glance| self.bench.fit(&glance.hypotheses, &glance.fit.starts, FULL));
        let mut full: Vec<Node> = full.collect();
        best_first(&mut full);
        if let Some(first) = full.first_mut() {
            *first = self.bench.settle_static(first.clone());
        }
        full.retain(|node| deviance(node) < deviance(nominal));
        full
    }
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
