//! What one more effect promises: a single step of the fit, from its own size.

use rayon::prelude::*;

use crate::windows::bench::{Bench, Node};
use crate::windows::hypothesis::{Hypothesis, come_round, is_limit};
use crate::windows::linear;
use crate::windows::misfit::Misfit;
use crate::windows::window::LOCALS;

/// How far a candidate may move what is measured, over what is unexplained, where that makes it
/// worse; by how much (−2 ln L) that is, or better; and how often it is made smaller.
const BESIDE: f64 = 3.0;
const ARRIVED: f64 = 1.0;
const SHRUNK: usize = 3;

/// What one more effect promises, to first order.
#[derive(Debug, Clone)]
pub(crate) struct Promise {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) starts: Vec<[f64; LOCALS]>,
    pub(crate) deviance: f64,
}

impl Bench {
    /// What each candidate promises beside the effects of `node`, best first.
    pub(crate) fn promises(&self, node: &Node, candidates: &[Hypothesis]) -> Vec<Promise> {
        let promises = candidates.par_iter().filter_map(|c| self.promise(node, c));
        let mut promises: Vec<Promise> = promises.collect();
        promises.sort_by(|a, b| a.deviance.total_cmp(&b.deviance));
        promises
    }

    /// −2 ln L with these hypotheses at their values and with the starts of `node`, moved to first
    /// order to where they fit best.
    pub(crate) fn started(&self, node: &Node, hypotheses: &[Hypothesis]) -> Option<f64> {
        self.posed(hypotheses, &self.windows, |problem, values| {
            let base = problem.residuals(values, &node.fit.starts)?;
            Some(self.eased(node, &base).deviance())
        })
    }

    /// What `residuals` from the starts of `node` come to where these fit best, to first order.
    pub(crate) fn eased(&self, node: &Node, residuals: &[Vec<f64>]) -> Misfit {
        let weights = Misfit::new(&self.windows, residuals).weights();
        let windows = self.windows.iter().zip(&node.fit.linear).zip(residuals);
        let predicted = windows.map(|((window, linear), base)| {
            let own = linear.without_globals();
            let normal = own.normal(window, &weights, base, &[]);
            let step = linear::step(&[normal], 1e-9, |_, step| step);
            own.predicted(base, &[], &step.locals[0], &[])
        });
        let predicted: Vec<Vec<f64>> = predicted.collect();
        Misfit::new(&self.windows, &predicted)
    }

    /// The candidate, made so small that it moves what is measured no more than what is unexplained
    /// where it would make it worse, and the residuals then. What is smaller than its probe may not
    /// show from there: what rests under a large friction says nothing of a small one.
    fn sized(&self, node: &Node, candidate: &Hypothesis) -> Option<(Hypothesis, Vec<Vec<f64>>)> {
        let residuals = |candidate: &Hypothesis| {
            let mut hypotheses = node.hypotheses.clone();
            hypotheses.push(candidate.clone());
            self.posed(&hypotheses, &self.windows, |problem, values| {
                problem.residuals(values, &node.fit.starts)
            })
        };
        let change = |residuals: &[Vec<f64>]| {
            self.eased(node, residuals).deviance() - node.fit.misfit.deviance()
        };
        let worse = |residuals: &[Vec<f64>]| change(residuals) > ARRIVED;
        let mut sized = candidate.clone();
        let mut base = residuals(&sized)?;
        if candidate.is_abrupt() {
            return (change(&base) < -ARRIVED).then_some((sized, base));
        }
        // a product of two numbers shows nothing of one where the other is too small
        let kept = candidate.is_threshold() || is_limit(candidate.info) || candidate.is_local();
        let (times, most) = match candidate.values.len() {
            _ if kept => (0, 1.0),
            1 => (SHRUNK, 0.2),
            _ => (1, 1.0),
        };
        for _ in 0..times {
            if !worse(&base) {
                break;
            }
            let wanted = BESIDE * node.fit.misfit.worst().1.max(1.0);
            let share = (wanted / self.moved(node, &base).max(1e-9)).min(most);
            let (name, size) = &mut sized.values[0];
            let nothing = candidate.nothing(&self.model, name);
            let before = std::mem::replace(size, nothing + (*size - nothing) * share);
            match residuals(&sized) {
                Some(smaller) => base = smaller,
                // smaller than it can be
                None => {
                    sized.values[0].1 = before;
                    break;
                }
            }
        }
        Some((sized, base))
    }

    /// How far residuals lie from those of `node` (deviations), in the channel that moved most.
    fn moved(&self, node: &Node, residuals: &[Vec<f64>]) -> f64 {
        let pairs = residuals.iter().zip(&node.fit.linear);
        let moved = pairs.map(|(after, linear)| {
            let pairs = after.iter().zip(&linear.residuals);
            pairs.map(|(after, before)| after - before).collect()
        });
        let moved: Vec<Vec<f64>> = moved.collect();
        Misfit::new(&self.windows, &moved).worst().1
    }

    /// One step of the fit from the candidate's own values.
    fn promise(&self, node: &Node, candidate: &Hypothesis) -> Option<Promise> {
        let (candidate, base) = self.sized(node, candidate)?;
        let mut hypotheses = node.hypotheses.clone();
        hypotheses.push(candidate.clone());
        self.posed(&hypotheses, &self.windows, |problem, values| {
            let (known, starts) = (node.fit.values.len(), &node.fit.starts);
            let mut steps = problem.first_steps(values);
            let columns = problem.columns(values, starts, &base, &mut steps, known)?;
            let more = |w: usize| columns.iter().map(|c| c[w].as_slice()).collect::<Vec<_>>();
            let mut weights = node.fit.misfit.weights();
            let mut best: Option<Promise> = None;
            for _ in 0..2 {
                let windows = self.windows.iter().zip(&node.fit.linear).zip(&base);
                let normals: Vec<_> = windows
                    .enumerate()
                    .map(|(w, ((window, linear), base))| {
                        linear.normal(window, &weights, base, &more(w))
                    })
                    .collect();
                let step = linear::step(&normals, 1e-9, |i, step| {
                    // where a place ends is no matter of first order
                    if candidate.is_placed() && i >= known {
                        return 0.0;
                    }
                    problem.bounded(i, values[i], step)
                });
                let predicted: Vec<Vec<f64>> = node
                    .fit
                    .linear
                    .iter()
                    .zip(&base)
                    .zip(&step.locals)
                    .enumerate()
                    .map(|(w, ((linear, base), locals))| {
                        linear.predicted(base, &more(w), locals, &step.globals)
                    })
                    .collect();
                let misfit = Misfit::new(&self.windows, &predicted);
                weights = misfit.weights();
                let deviance = misfit.deviance();
                if !best.as_ref().is_some_and(|best| best.deviance <= deviance) {
                    let mut hypothesis = candidate.clone();
                    let own = hypothesis.values.iter_mut().zip(&step.globals[known..]);
                    own.for_each(|((name, value), step)| {
                        *value = come_round(candidate.info, name, *value + step);
                    });
                    let mut starts = starts.clone();
                    for (start, step) in starts.iter_mut().zip(&step.locals) {
                        start.iter_mut().zip(step).for_each(|(s, d)| *s += d);
                    }
                    best = Some(Promise {
                        hypothesis,
                        starts,
                        deviance,
                    });
                }
            }
            best.filter(|best| best.deviance.is_finite())
        })
    }

    /// The node with one more effect, fitted from what it promises.
    pub(crate) fn follow(&self, node: &Node, promise: &Promise, rounds: usize) -> Option<Node> {
        let mut hypotheses = node.hypotheses.clone();
        hypotheses.push(promise.hypothesis.clone());
        let next = self
            .fit(&hypotheses, &promise.starts, rounds)
            .or_else(|| self.fit(&hypotheses, &node.fit.starts, rounds))?;
        if promise.hypothesis.is_threshold() {
            return Some(self.settle_threshold(next));
        }
        Some(next)
    }
}
