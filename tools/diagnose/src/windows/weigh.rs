//! What was found, weighed: what each effect brings, what could stand in its place, and what the
//! catalogue does not hold.

use crate::windows::bench::{FULL, Node, SPOILT};
use crate::windows::hypothesis::Hypothesis;
use crate::windows::interval::SIDES;
use crate::windows::pay::{SIGMAS, due};
use crate::windows::score;
use crate::windows::search::{Search, deviance, score};
use crate::windows::unknown::{self, Beyond, Unknown};
use crate::windows::wander::Wander;

/// Δ(−2 ln L) within which two effects cannot be told apart.
const TWINS: f64 = 9.0;
/// Deviations by which an effect has to differ from nothing beside a force outside of the catalogue:
/// what such a force leaves is no noise. Where no level of the noise is known, it counts as such.
const BESIDE: f64 = 2.0 * SIGMAS;
/// Share of what an effect promises that another has to promise to be tried in its place, and share of
/// what it brings that this is at least: first steps may be short.
const RIVAL: f64 = 0.5;
const SHORT: f64 = 0.2;

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
    /// Forces without pattern, were there nothing else beside what the catalogue holds, and ln L that
    /// they bring.
    pub(crate) wander: Option<(Wander, f64)>,
    /// The search was stopped for the work that it took.
    pub(crate) stopped: bool,
}

impl Search<'_> {
    /// What was found, weighed, and what the catalogue does not hold.
    pub(crate) fn concluded(&self, nominal: Node, best: Node, looked_at: usize) -> Found {
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
            let gone = |h: &Hypothesis| !fewer.hypotheses.iter().any(|kept| kept.is_like(h));
            let without = || best.hypotheses.iter().filter(|h| gone(h));
            let pieces = without().all(Hypothesis::is_momentary);
            let due: f64 = without().map(due).sum();
            let Some((alone, than)) = unknown::beside(self.bench, &fewer).zip(beside.as_ref())
            else {
                continue;
            };
            let leads = alone.leads().zip(than.leads());
            if alone.score < than.score || leads.is_some_and(|(alone, than)| alone < than + due) {
                // what explains more by itself than all that was found needs none of it
                (best, beside) = (fewer, Some(alone));
            } else if pieces && alone.unknown.is_some() {
                // pushes that do not explain all may be pieces of it: beside them it shows the more
                // clearly what it follows
                best = fewer;
                beside = if than.is_of_moments() {
                    Some(alone)
                } else {
                    beside.map(|named| Beyond {
                        score: alone.score,
                        ..named
                    })
                };
            }
        }
        if let Some(unknown) = beside.as_mut().and_then(|beyond| beyond.unknown.as_mut()) {
            best = self.taken_over(best, unknown);
        }
        let mut found = self.weighed(nominal, best, looked_at);
        if let Some(beyond) = beside.filter(|_| !self.bench.is_noise(&found.node)) {
            found.unknown = beyond.unknown;
            found.wander = Some((beyond.wander, beyond.gain));
        }
        found
    }

    /// The node without the effects that a force outside of the catalogue makes needless.
    fn taken_over(&self, mut node: Node, unknown: &mut Unknown) -> Node {
        let sigmas = if self.bench.knows_noise() {
            BESIDE
        } else {
            SIDES
        };
        let mut at = 0;
        while at < node.hypotheses.len() {
            // of what may as well be nothing nothing is claimed
            let idle = !self.is_clear(&node, at, sigmas);
            if !(idle || unknown.predicts()) {
                at += 1;
                continue;
            }
            let mut without = node.hypotheses.clone();
            let removed = without.remove(at);
            (self.progress)(&format!("without {}", removed.info.id));
            let due = if idle { f64::INFINITY } else { due(&removed) };
            let less = self.bench.fit(&without, &node.fit.starts, FULL);
            let taken = less.and_then(|less| {
                let over = unknown::takes_over(self.bench, &less, unknown, due);
                let over = over.or_else(|| idle.then(|| unknown.without_law()))?;
                Some((less, over))
            });
            match taken {
                Some((less, over)) => (node, *unknown, at) = (less, over, 0),
                None => at += 1,
            }
        }
        node
    }

    /// Whether the effects of a node, fitted to every other window, predict the rest no worse than the
    /// nominal model does.
    fn holds(&self, node: &Node) -> bool {
        if node.hypotheses.is_empty() {
            return true;
        }
        let bench = self.bench;
        let before = score::prediction(bench, &bench.windows, &[]);
        let after = score::held_out(bench, &node.hypotheses, None);
        score::total(&after) < SPOILT * score::total(&before)
    }

    /// The node without its pushes, if it has any and other effects.
    fn without_pushes(&self, node: &Node) -> Option<Node> {
        let lasting = node.hypotheses.iter().filter(|h| !h.is_momentary());
        let lasting: Vec<Hypothesis> = lasting.cloned().collect();
        if lasting.len() == node.hypotheses.len() || lasting.is_empty() {
            return None;
        }
        self.bench.fit(&lasting, &node.fit.starts, FULL)
    }

    /// What an effect promises beside `node` from where a search for it begins (−2 ln L); none for
    /// what has no such start.
    fn promised(&self, node: &Node, starts: &[Hypothesis]) -> Option<f64> {
        let promises = self.bench.promises(node, starts);
        promises.first().map(|best| deviance(node) - best.deviance)
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
            if score(&less) < score(&node) {
                // a fit that had not come to its end
                (node, gains, twins, at) = (less, Vec::new(), Vec::new(), 0);
                continue;
            }
            let candidates = self.candidates(&less).into_iter();
            let candidates = candidates.filter(|h| !without.iter().any(|k| k.is_like(h)));
            let (own, others): (Vec<_>, Vec<_>) = candidates.partition(|h| h.is_like(&removed));
            let brings = deviance(&less) - deviance(&node);
            let promised = self
                .promised(&less, &own)
                .map_or(brings, |promised| promised.max(SHORT * brings).min(brings));
            let rivals = self.followed(&less, &others, RIVAL * promised);
            if let Some(rival) = rivals.iter().find(|r| {
                self.is_clear(r, r.hypotheses.len() - 1, SIGMAS) && !self.bench.spoils(&node, r)
            }) && score(rival) < score(&node) - 3.0
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
            stopped: false,
        }
    }
}
