//! What an effect has to bring to be accepted, and to stay.

use std::cell::{LazyCell, OnceCell};

use crate::windows::around::around;
use crate::windows::bench::{FULL, Node};
use crate::windows::follow::LOOK;
use crate::windows::hypothesis::{Hypothesis, is_limit, is_where};
use crate::windows::interval::SIDES;
use crate::windows::misfit::Misfit;
use crate::windows::search::{Search, deviance};
use crate::windows::track::Sensor;
use crate::windows::wander::{Judge, Wander};
use crate::windows::window::Window;

/// How many times what is due an effect has to bring, to noise, to be certain without a parameter of
/// its own that is.
const CERTAIN: f64 = 10.0;
/// Δ(−2 ln L) that one more effect has to bring, and for each parameter more.
pub(crate) const PAY: [f64; 2] = [40.0, 6.0];
/// Pushes at most: a force that acts again and again is no push.
const PUSHES: usize = 2;
/// Share of −2 ln L that a push leaves at most of the window in which it acts: what leaves more is a
/// piece of another force.
const PIECE: f64 = 0.5;
/// Share of the gain so far in a channel that one more effect has to bring there where noise is
/// reached: less is what integrators differ by.
const SHARE: f64 = 0.02;
/// Δ(−2 ln L) that it has to bring on windows that its parameters were not fitted to: 2 ln of some
/// hundred tests over a hundredth.
pub(crate) const HELD_OUT: f64 = 18.0;
/// How many times worse a model without one of its effects is, after a few rounds, for that to be
/// needed beyond doubt.
const WORSE: f64 = 3.0;
/// Estimate over deviation that each effect has to keep in one of its parameters.
pub(crate) const SIGMAS: f64 = 4.2;

/// Forces without pattern that explain all that a node leaves.
pub(crate) struct Beside<'a> {
    node: &'a Node,
    wander: Wander,
    /// −2 ln L with answers taken around these forces, once asked for.
    around: OnceCell<Option<f64>>,
}

/// What an effect has to bring.
pub(crate) fn due(hypothesis: &Hypothesis) -> f64 {
    PAY[0] + PAY[1] * (hypothesis.values.len() as f64 - 1.0)
}

/// Whether `after` brings no more over `before` than integrators differ by and what is `due`.
fn is_slight(nominal: &Node, before: &Node, after: &Node, due: f64) -> bool {
    let [first, before, misfit] = [nominal, before, after].map(|node| &node.fit.misfit);
    misfit.clear_gain_over(before, first, SHARE) < due
}

impl Search<'_> {
    /// Whether so little is left that no further effect could bring its share.
    pub(crate) fn is_done(&self, nominal: &Node, node: &Node) -> bool {
        let (first, misfit) = (&nominal.fit.misfit, &node.fit.misfit);
        let left = misfit.perfect().clear_gain_over(misfit, first, SHARE);
        self.bench.is_noise(node) && left < PAY[0]
    }

    /// Small forces without pattern beside `node`, if they explain all that it leaves.
    pub(crate) fn wandering<'n>(&self, node: &'n Node) -> Option<Beside<'n>> {
        if self.bench.is_noise(node) {
            return None;
        }
        let wander = Judge::new(self.bench, node)?.alone()?;
        wander.is_noise(self.bench).then(|| Beside {
            node,
            wander,
            around: OnceCell::new(),
        })
    }

    pub(crate) fn pays<'n>(
        &self,
        nominal: &Node,
        before: &Node,
        after: &Node,
        beside: &LazyCell<Option<Beside<'n>>, impl FnOnce() -> Option<Beside<'n>>>,
    ) -> bool {
        let Some(own) = after.hypotheses.last() else {
            return false;
        };
        let gain = after.fit.misfit.gain_over(&before.fit.misfit);
        if self.bench.is_noise(before) && is_slight(nominal, before, after, due(own)) {
            return false;
        }
        let last = after.hypotheses.len() - 1;
        let brings =
            self.bench.is_noise(after) && gain > CERTAIN * due(own) && self.may(after, last);
        let sigmas = self.sigmas(before, after);
        // a size that is tried, and one of which all that is larger does nothing, have no deviation
        let tried = own.is_threshold() || is_limit(own.info);
        if gain <= due(own)
            || tried && gain < sigmas * sigmas
            || own.is_momentary()
                && (self.is_piece(before, after, own) || !self.is_clear(after, last, SIDES))
            || !(brings || self.is_clear(after, last, sigmas))
            || !self.is_right(before, after) && self.bench.spoils(before, after)
        {
            return false;
        }
        let certain = gain > CERTAIN * due(own) || !self.slips(after);
        if self.bench.is_noise(after) && (certain || own.is_local()) {
            return true;
        }
        if let Some(beside) = LazyCell::force(beside) {
            return self.is_likelier(beside, after, due(own));
        }
        // what repeats in every fit may be a part of something else, or how simulators differ in a
        // single slide
        let proven = own.is_local() || self.bench.windows.len() < 4;
        proven || self.bench.held_out_gain(before, after) > HELD_OUT
    }

    /// Whether a push leaves much of the window in which it acts.
    fn is_piece(&self, before: &Node, after: &Node, push: &Hypothesis) -> bool {
        let at_s = push.values.first().map_or(f64::NAN, |(_, at_s)| *at_s);
        let windows = &self.bench.windows;
        let acts = |w: &Window| {
            push.only.is_none_or(|run| run == w.run) && (w.from_s..w.to_s).contains(&at_s)
        };
        windows.iter().position(acts).is_none_or(|w| {
            let left = |node: &Node| {
                let own = std::slice::from_ref(&node.fit.linear[w].residuals);
                Misfit::new(&windows[w..=w], own).deviance()
            };
            left(after) > PIECE * left(before)
        })
    }

    /// Whether `after` brings more than `due` over the node that forces without pattern are beside,
    /// such forces beside both. It has to where answers are taken around these forces as well: where
    /// residuals are large, what is of second order is larger than what is due.
    fn is_likelier(&self, beside: &Beside, after: &Node, due: f64) -> bool {
        let Some(judge) = Judge::new(self.bench, after) else {
            return false;
        };
        let alone = judge.alone();
        if alone.is_none_or(|own| own.deviance >= beside.wander.deviance - due) {
            return false;
        }
        let around = |node, judge| Some(around(self.bench, node, judge)?.1.alone()?.deviance);
        let before = *beside.around.get_or_init(|| {
            let judge = Judge::new(self.bench, beside.node)?;
            around(beside.node, judge)
        });
        let after = around(after, judge);
        before
            .zip(after)
            .is_some_and(|(before, after)| after < before - due)
    }

    /// Whether an effect is within its bounds, and no push too many.
    pub(crate) fn may(&self, node: &Node, which: usize) -> bool {
        let pushes = node.hypotheses.iter().filter(|h| h.is_momentary());
        let own = &node.hypotheses[which];
        !own.is_at_bound() && !own.is_instant() && pushes.count() <= PUSHES
    }

    /// Deviations by which the last effect of `after` has to differ from nothing: more where it explains
    /// less than a count of the encoders, which integrators may differ by.
    fn sigmas(&self, before: &Node, after: &Node) -> f64 {
        let [before, after] = [before, after].map(|node| &node.fit.misfit);
        let gains = after.gains_over(before);
        let wheels = Sensor::WheelAngle.channel()..Sensor::Pose.channel();
        let by_wheels: f64 = gains[wheels.clone()].iter().sum();
        let count = self.bench.count();
        let met = wheels
            .clone()
            .all(|c| before.mean_square(c) < count * count);
        if met && by_wheels > 0.5 * gains.iter().sum::<f64>() {
            SIGMAS * count
        } else {
            SIGMAS
        }
    }

    /// Whether an effect's size differs from nothing by so many of its own deviations.
    pub(crate) fn is_clear(&self, node: &Node, which: usize, sigmas: f64) -> bool {
        let fitted = |h: &Hypothesis| if h.is_threshold() { 0 } else { h.values.len() };
        let first: usize = node.hypotheses[..which].iter().map(fitted).sum();
        let own = &node.hypotheses[which];
        if !self.may(node, which) {
            return false;
        }
        own.is_threshold()
            || own.values.iter().enumerate().any(|(i, (name, value))| {
                if is_where(own.info, name) {
                    return false;
                }
                let nothing = own.nothing(&self.bench.model, name);
                (value - nothing).abs() > sigmas * node.fit.deviations[first + i]
            })
    }

    /// The node with these of its effects alone. `None` if that is far worse after a few rounds: what
    /// is gone then brings more than is `due`.
    fn less(&self, node: &Node, without: &[Hypothesis], due: f64) -> Option<Node> {
        let far = WORSE * deviance(node) + CERTAIN * due;
        let look = self.bench.fit(without, &node.fit.starts, LOOK)?;
        if deviance(&look) > far {
            return None;
        }
        self.bench.fit(&look.hypotheses, &look.fit.starts, FULL)
    }

    /// Takes out what no longer pays beside what came later.
    pub(crate) fn pruned(&self, nominal: &Node, mut node: Node) -> Node {
        let mut at = 0;
        while node.hypotheses.len() > 1 && at < node.hypotheses.len() {
            let mut without = node.hypotheses.clone();
            let removed = without.remove(at);
            (self.progress)(&format!("without {}", removed.info.id));
            let less = self.less(&node, &without, due(&removed));
            let idle = |less: &Node| {
                let gain = node.fit.misfit.gain_over(&less.fit.misfit);
                let explained = || {
                    self.wandering(less)
                        .is_some_and(|beside| !self.is_likelier(&beside, &node, due(&removed)))
                };
                gain < due(&removed)
                    || self.bench.is_noise(less) && is_slight(nominal, less, &node, due(&removed))
                    || !self.bench.is_noise(&node) && explained()
            };
            match less.filter(idle) {
                Some(less) => (node, at) = (less, 0),
                None => at += 1,
            }
        }
        node
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;
    use slipstream_sim::effects::find;

    use crate::windows::bench::FULL;
    use crate::windows::fixture;

    use super::*;

    /// Torques (N m) that no record of commands shows, beside those that one does.
    fn shaken(t_s: f64) -> [f64; 2] {
        let [right, left] = fixture::gentle(t_s);
        let hum = |rates: [f64; 3]| rates.iter().map(|w| (w * t_s + w).sin()).sum::<f64>();
        [
            right + 0.01 * hum([7.3, 11.9, 2.7]),
            left + 0.01 * hum([6.1, 13.7, 3.3]),
        ]
    }

    /// What other wheel radii bring on a shaken robot whose radii are off by this factor, to first order
    /// around no forces, and whether they are likelier.
    fn radii(scale: f64) -> (f64, bool) {
        let model = RobotModel::default();
        let scales = [("right_scale", scale), ("left_scale", scale)];
        let truth = model.clone().with("wheel_radius", &scales);
        let mut track = fixture::driven(&truth, 10.0, shaken);
        track.commands = fixture::driven(&truth, 10.0, fixture::gentle).commands;
        let bench = fixture::bench(track, model);
        let search = Search {
            bench: &bench,
            all: Vec::new(),
            excluded: &[],
            known: Vec::new(),
            cuts: false,
            progress: &|_| (),
        };
        let starts = bench.guesses(&bench.windows).unwrap();
        let own = Hypothesis::new(find("wheel_radius").unwrap(), scales.to_vec());
        let before = bench.fit(&[], &starts, FULL).unwrap();
        let after = bench.fit(&[own], &starts, FULL).unwrap();
        let alone = |node| Judge::new(&bench, node).unwrap().alone().unwrap();
        let beside = Beside {
            node: &before,
            wander: alone(&before),
            around: OnceCell::new(),
        };
        let brings = beside.wander.deviance - alone(&after).deviance;
        let due = due(&after.hypotheses[0]);
        (brings - due, search.is_likelier(&beside, &after, due))
    }

    #[test]
    fn what_is_of_second_order_beside_large_forces_is_no_effect() {
        let (brings, is_likelier) = radii(1.0);
        assert!(brings > 0.0, "{brings}");
        assert!(!is_likelier);
    }

    #[test]
    fn an_effect_is_likelier_beside_large_forces() {
        assert!(radii(1.03).1);
    }
}
