//! Fits that have to be led: over ever longer windows, and to numbers that have no derivative.

use rayon::prelude::*;

use crate::windows::bench::{Bench, FULL, HELD_OUT, Node};
use crate::windows::follow::GLANCE;
use crate::windows::hypothesis::{Hypothesis, KINETIC, STATIC, all_sizes, threshold};
use crate::windows::search::deviance;
use crate::windows::window::{LOCALS, Window};

/// Static over kinetic friction where a search for the former begins.
const STATIC_OVER_KINETIC: [f64; 5] = [1.008, 1.025, 1.06, 1.12, 1.25];
/// Shares of what it is above, around the best so far, that are tried next.
const STATIC_CLOSER: [[f64; 4]; 3] = [
    [0.5, 0.7, 1.4, 2.0],
    [0.8, 0.9, 1.1, 1.25],
    [0.94, 0.97, 1.03, 1.06],
];

/// Shares of a gap that are tried next, around the best so far.
const GAP_CLOSER: [&[f64]; 4] = [
    &[0.4, 0.55, 0.68, 1.25, 1.5, 1.8, 2.2, 2.7],
    &[0.75, 0.88, 1.14, 1.33],
    &[0.94, 0.97, 1.03, 1.06],
    &[0.985, 0.993, 1.007, 1.015],
];

/// How many sizes of commands off a threshold may lie behind ones that fit worse.
const BEHIND: usize = 16;

/// How often a patch is moved, by how many of its radii, and by how much it grows or shrinks.
const PATCH_ROUNDS: usize = 3;
const PATCH_MOVES: [[f64; 2]; 5] = [[0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]];
const PATCH_SCALES: [f64; 3] = [0.7, 1.0, 1.4];

/// Heads of the windows that are fitted before the whole (s).
const HORIZONS_S: [f64; 3] = [1.0, 1.8, 3.2];

impl Bench {
    /// Fits anew in every way that there is, until noise is reached.
    pub(crate) fn settled(&self, node: Node) -> Node {
        let grown = self.settle_static(self.grown(node));
        let placed = self.settle_patch(self.settle_gap(grown));
        if self.is_noise(&placed) {
            return placed;
        }
        self.settle_threshold(placed)
    }

    /// Fits anew over ever longer heads of the windows, where a model does not reach the noise: over
    /// a long time the misfit of what slides and sticks has many valleys.
    pub(crate) fn grown(&self, node: Node) -> Node {
        if self.is_noise(&node) {
            return node;
        }
        let better = |grown: &Node| deviance(grown) < deviance(&node) && !self.spoils(&node, grown);
        let grown = self.led(&node.hypotheses);
        grown.filter(better).unwrap_or(node)
    }

    /// The effects fitted over ever longer heads of the windows, from the values that they have.
    pub(crate) fn led(&self, hypotheses: &[Hypothesis]) -> Option<Node> {
        let (mut hypotheses, mut starts) = (hypotheses.to_vec(), self.guesses(&self.windows)?);
        for over_s in HORIZONS_S {
            let heads = self.heads(over_s);
            let short = self.fit_on(&heads, &hypotheses, &starts, HELD_OUT)?;
            (hypotheses, starts) = (short.hypotheses, short.fit.starts);
        }
        self.fit(&hypotheses, &starts, FULL)
    }

    /// Where the windows begin in the nominal model with `hypotheses` as they are, fitted over ever
    /// longer heads.
    pub(crate) fn begun(&self, hypotheses: &[Hypothesis]) -> Option<Vec<[f64; LOCALS]>> {
        let mut starts = self.guesses(&self.windows)?;
        for over_s in HORIZONS_S.into_iter().chain([f64::INFINITY]) {
            let heads = self.heads(over_s);
            let fit = self.posed(hypotheses, &heads, |problem, _| {
                problem.with_free(&[]).fit(&[], &starts, HELD_OUT)
            })?;
            starts = fit.starts;
        }
        Some(starts)
    }

    /// The first `over_s` of every window.
    pub(crate) fn heads(&self, over_s: f64) -> Vec<Window> {
        let heads = self.windows.iter();
        let heads = heads.map(|window| window.head(&self.tracks[window.run], over_s));
        heads.collect()
    }

    /// Tries static frictions above the kinetic one: from below it nothing shows the way.
    pub(crate) fn settle_static(&self, node: Node) -> Node {
        let slip = node
            .hypotheses
            .iter()
            .position(|h| h.value(STATIC).is_some());
        let Some(slip) = slip.filter(|_| !self.is_noise(&node)) else {
            return node;
        };
        let mut best = self.with_static(&node, slip, &STATIC_OVER_KINETIC);
        for closer in STATIC_CLOSER {
            let own = &best.hypotheses[slip];
            let (Some(above), Some(kinetic)) = (own.value(STATIC), own.value(KINETIC)) else {
                break;
            };
            if self.is_noise(&best) {
                break;
            }
            let over = above / kinetic - 1.0;
            best = self.with_static(&best, slip, &closer.map(|share| 1.0 + over * share));
        }
        best
    }

    /// The best of the node and of fits that begin with these ratios of static to kinetic friction.
    fn with_static(&self, node: &Node, slip: usize, ratios: &[f64]) -> Node {
        self.best_of(node, begun_with_static(node, slip, ratios), HELD_OUT)
    }

    /// Fits that begin with other ratios of static to kinetic friction than a node has.
    pub(crate) fn with_other_statics(&self, node: &Node, slip: usize) -> Vec<Node> {
        let begun = begun_with_static(node, slip, &STATIC_OVER_KINETIC);
        self.fits_of(node, begun, HELD_OUT)
    }

    /// Tries gaps around that of a play: the blows with which gears meet make its derivative useless.
    pub(crate) fn settle_gap(&self, node: Node) -> Node {
        let Some(own) = node.hypotheses.iter().position(Hypothesis::has_play) else {
            return node;
        };
        let mut best = node;
        for closer in GAP_CLOSER {
            if self.is_noise(&best) {
                break;
            }
            let begun = closer.iter().map(|share| {
                let mut hypotheses = best.hypotheses.clone();
                hypotheses[own].values[0].1 *= share;
                hypotheses
            });
            best = self.best_of(&best, begun.collect(), HELD_OUT);
        }
        best
    }

    /// Tries places and radii around a patch: where a wheel comes onto it and leaves it again, circles
    /// of many sizes pass.
    pub(crate) fn settle_patch(&self, node: Node) -> Node {
        let mut patches = node.hypotheses.iter();
        let Some(patch) = patches.position(Hypothesis::is_placed) else {
            return node;
        };
        let mut best = node;
        for _ in 0..PATCH_ROUNDS {
            if self.is_noise(&best) {
                break;
            }
            let begun = PATCH_MOVES.iter().flat_map(|[x, y]| {
                PATCH_SCALES.map(|scale| {
                    let mut hypotheses = best.hypotheses.clone();
                    let values = &mut hypotheses[patch].values;
                    let radius_m = values[2].1;
                    values[0].1 += x * radius_m;
                    values[1].1 += y * radius_m;
                    values[2].1 *= scale;
                    hypotheses
                })
            });
            let next = self.best_of(&best, begun.collect(), HELD_OUT);
            if deviance(&next) > deviance(&best) - 1.0 {
                break;
            }
            best = next;
        }
        best
    }

    /// Fits from these values and where a node begins.
    fn fits_of(&self, node: &Node, begun: Vec<Vec<Hypothesis>>, rounds: usize) -> Vec<Node> {
        begun
            .into_par_iter()
            .filter_map(|hypotheses| self.fit(&hypotheses, &node.fit.starts, rounds))
            .collect()
    }

    /// The best of the node and of fits from these of at most so many `rounds`.
    fn best_of(&self, node: &Node, begun: Vec<Vec<Hypothesis>>, rounds: usize) -> Node {
        let tried = self.fits_of(node, begun, rounds);
        let better = tried
            .into_iter()
            .min_by(|a, b| deviance(a).total_cmp(&deviance(b)));
        let better = better.filter(|better| deviance(better) < deviance(node));
        better.unwrap_or_else(|| node.clone())
    }

    /// Tries the sizes of commands around a threshold, by ever smaller strides, until none fits better;
    /// in the end those around it that lie behind a worse one, too: commands of one moment that are
    /// nearly the same size fit worst where some of them do something and others nothing.
    pub(crate) fn settle_threshold(&self, node: Node) -> Node {
        let own = node.hypotheses.iter().position(Hypothesis::is_threshold);
        let (Some(track), Some(own)) = (self.tracks.first(), own) else {
            return node;
        };
        let sizes = all_sizes(track, &self.model);
        let mut best = node;
        let mut stride = (sizes.len() / 8).max(1);
        loop {
            let strides = match stride {
                0 => 2..=BEHIND,
                _ => stride..=stride,
            };
            let at = sizes.partition_point(|size| *size < best.hypotheses[own].values[0].1);
            let near = strides.flat_map(|by| [at.checked_sub(by), Some(at + by)]);
            let near = near.flatten().filter(|i| *i <= sizes.len());
            let begun = near.map(|i| {
                let mut hypotheses = best.hypotheses.clone();
                hypotheses[own].values[0].1 = threshold(&sizes, i);
                hypotheses
            });
            let next = self.best_of(&best, begun.collect(), GLANCE);
            if deviance(&next) < deviance(&best) {
                (best, stride) = (next, stride.max(1));
            } else if stride > 0 {
                stride = stride.div_ceil(2).min(stride - 1);
            } else {
                return best;
            }
        }
    }
}

/// The effects of a node with these ratios of static to kinetic friction.
fn begun_with_static(node: &Node, slip: usize, ratios: &[f64]) -> Vec<Vec<Hypothesis>> {
    let Some(kinetic) = node.hypotheses[slip].value(KINETIC) else {
        return Vec::new();
    };
    let begun = ratios.iter().map(|ratio| {
        let mut hypotheses = node.hypotheses.clone();
        hypotheses[slip].set(STATIC, kinetic * ratio);
        hypotheses
    });
    begun.collect()
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;
    use slipstream_sim::effects::find;

    use super::*;
    use crate::windows::fixture;

    /// How many commands in a row are nearly the same size.
    const HELD: f64 = 12.0;

    /// Torques (N m) that for a moment are nearly the same size, one way and then the other.
    fn holding(t_s: f64) -> [f64; 2] {
        let [right, left] = fixture::gentle(t_s);
        let step = ((t_s - 4.0) / fixture::HOLD_S).round();
        if !(0.0..HELD).contains(&step) {
            return [right, left];
        }
        let sign = if step < 0.5 * HELD { 1.0 } else { -1.0 };
        let size = sign * (0.02 + 1e-5 * step);
        [size, size]
    }

    #[test]
    fn a_threshold_is_found_behind_sizes_that_fit_worse() {
        let model = RobotModel::default();
        let truth = model
            .clone()
            .with("command_dead_band", &[("torque_nm", 0.0202)]);
        let bench = fixture::bench(fixture::driven(&truth, 10.0, holding), model);
        let begun = Hypothesis::new(
            find("command_dead_band").unwrap(),
            vec![("torque_nm", 0.0156)],
        );
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[begun], &starts, FULL).unwrap();
        let found = bench.settle_threshold(node);
        let found = found.hypotheses[0].values[0].1;
        let sizes = all_sizes(&bench.tracks[0], &bench.model);
        let between = |size: f64| sizes.partition_point(|known| *known < size);
        assert_eq!(between(found), between(0.0202), "{found}");
    }
}
