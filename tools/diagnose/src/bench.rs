//! What is looked at: tracks, windows and the nominal model, and models fitted to them.

use rayon::prelude::*;
use slipstream_bus::RobotModel;
use slipstream_sim::{CommandKind, Listed, read_effects};

use crate::fit::{Fit, Free, Problem};
use crate::hypothesis::{Hypothesis, KINETIC, STATIC, all_sizes};
use crate::linear;
use crate::local::is_local;
use crate::misfit::Misfit;
use crate::simulate::is_exact_at_any_step;
use crate::start;
use crate::track::{CHANNELS, Track};
use crate::window::{LOCALS, WINDOW_S, Window, cut, spread};

/// Longest step of a simulation (s).
const STEP_S: f64 = 2e-3;
/// The same where wheels turn exactly as told.
const LONG_STEP_S: f64 = 0.02;

/// Level (deviations) that counts as noise, where the noise is declared and where it is not.
const NOISE: f64 = 1.12;
const NOISE_UNDECLARED: f64 = 1.5;

/// Growth of the level of a channel that spoils it.
const SPOILT: f64 = 1.15;

/// Static over kinetic friction where a search for the former begins.
const STATIC_OVER_KINETIC: [f64; 5] = [1.008, 1.025, 1.06, 1.12, 1.25];
/// Shares of what it is above, around the best so far, that are tried next.
const STATIC_CLOSER: [[f64; 4]; 3] = [
    [0.5, 0.7, 1.4, 2.0],
    [0.8, 0.9, 1.1, 1.25],
    [0.94, 0.97, 1.03, 1.06],
];

/// How far a candidate may move what is measured, over what is unexplained, where that makes it
/// worse; by how much (−2 ln L) that is; and how often it is made smaller.
const BESIDE: f64 = 3.0;
const ARRIVED: f64 = 1.0;
const SHRUNK: usize = 3;

/// Heads of the windows that are fitted before the whole (s).
const HORIZONS_S: [f64; 3] = [1.0, 1.8, 3.2];

/// Rounds of a fit to a part of the windows, from the fit to all.
const HELD_OUT: usize = 6;

/// Rounds of a fit to the end.
pub(crate) const FULL: usize = 30;

/// The runs of one machine, cut into windows, and its nominal model.
pub(crate) struct Bench {
    pub(crate) tracks: Vec<Track>,
    pub(crate) windows: Vec<Window>,
    pub(crate) model: RobotModel,
}

/// The nominal model with these effects, fitted.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) hypotheses: Vec<Hypothesis>,
    pub(crate) fit: Fit,
}

/// What one more effect promises, to first order.
#[derive(Debug, Clone)]
pub(crate) struct Promise {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) starts: Vec<[f64; LOCALS]>,
    pub(crate) deviance: f64,
}

/// Effects as the plant takes them, and which of their numbers are fitted from which values.
struct Setting {
    list: Vec<Listed<f64>>,
    only: Vec<Option<usize>>,
    free: Vec<Free>,
    values: Vec<f64>,
}

/// The nominal model with `hypotheses`, in place of its own effects where they say so.
pub(crate) fn with(model: &RobotModel, hypotheses: &[Hypothesis]) -> RobotModel {
    let mut better = model.clone();
    for hypothesis in hypotheses {
        match hypothesis.replaces {
            Some(at) => better.effects[at] = hypothesis.spec(),
            None => better.effects.push(hypothesis.spec()),
        }
    }
    better
}

impl Bench {
    fn setting(&self, hypotheses: &[Hypothesis]) -> Option<Setting> {
        let model = with(&self.model, hypotheses);
        let list = read_effects(&model).ok()?;
        let mut only = vec![None; list.len()];
        let (mut free, mut values) = (Vec::new(), Vec::new());
        let mut next = self.model.effects.len();
        for hypothesis in hypotheses {
            let place = hypothesis.replaces.unwrap_or(next);
            next += usize::from(hypothesis.replaces.is_none());
            only[place] = hypothesis.only;
            for &(name, value) in &hypothesis.values {
                if !hypothesis.is_threshold() {
                    free.push((place, name));
                    values.push(value);
                }
            }
        }
        Some(Setting {
            list,
            only,
            free,
            values,
        })
    }

    fn step_s(&self, list: &[Listed<f64>]) -> f64 {
        let has = |ids: &[&str]| list.iter().any(|(info, _)| ids.contains(&info.id));
        let slips = has(&["wheel_slip", "friction_patch", "backlash"]);
        let lags = has(&["actuator_lag", "actuator_delay", "supply_sag"]);
        let kind = self.tracks.first().map_or(CommandKind::Torque, Track::kind);
        if is_exact_at_any_step(kind, slips, lags) {
            LONG_STEP_S
        } else {
            STEP_S
        }
    }

    /// Hands the problem of these hypotheses to `solve`, with the values to start from.
    pub(crate) fn posed<T>(
        &self,
        hypotheses: &[Hypothesis],
        windows: &[Window],
        solve: impl FnOnce(&Problem<'_>, &[f64]) -> Option<T>,
    ) -> Option<T> {
        let setting = self.setting(hypotheses)?;
        let problem = Problem {
            tracks: &self.tracks,
            windows,
            model: &self.model,
            list: &setting.list,
            only: &setting.only,
            free: &setting.free,
            step_s: self.step_s(&setting.list),
        };
        solve(&problem, &setting.values)
    }

    /// The same cut anew, so that no window begins in one of these times (s).
    pub(crate) fn avoiding(&self, times_s: &[[f64; 2]]) -> Self {
        let runs = self.tracks.iter().enumerate();
        let windows = runs.flat_map(|(run, track)| cut(track, run, WINDOW_S, times_s));
        Self {
            tracks: self.tracks.clone(),
            windows: spread(windows.collect(), self.windows.len().max(1)),
            model: self.model.clone(),
        }
    }

    /// Whether all windows begin as those of `other` do.
    pub(crate) fn begins_as(&self, other: &Self) -> bool {
        let begins =
            |bench: &Self| -> Vec<f64> { bench.windows.iter().map(|w| w.from_s).collect() };
        begins(self) == begins(other)
    }

    /// Whether what `node` leaves is noise in every channel.
    pub(crate) fn is_noise(&self, node: &Node) -> bool {
        (0..CHANNELS).all(|channel| self.excess(node, channel) < 1.0)
    }

    /// The channel that `node` leaves furthest above its noise, and its level (deviations).
    pub(crate) fn worst(&self, node: &Node) -> (usize, f64) {
        let excess = |c: &usize| self.excess(node, *c);
        let worst = (0..CHANNELS).max_by(|a, b| excess(a).total_cmp(&excess(b)));
        let channel = worst.unwrap_or(0);
        (channel, node.fit.misfit.mean_square(channel).sqrt())
    }

    /// Level of a channel over what still counts as noise: more where the noise is not declared.
    fn excess(&self, node: &Node, channel: usize) -> f64 {
        let level = node.fit.misfit.mean_square(channel).sqrt();
        if self.is_declared(channel) {
            level / NOISE
        } else {
            level / NOISE_UNDECLARED
        }
    }

    /// Whether the recording says how noisy a channel is.
    fn is_declared(&self, channel: usize) -> bool {
        let mut series = self.tracks.iter().flat_map(|track| &track.series);
        series.all(|series| {
            let first = series.sensor.channel();
            !(first..first + series.sensor.width()).contains(&channel) || series.declared
        })
    }

    /// Whether a channel of unknown noise is much further off in `after` than in `before`: where no
    /// model reaches the noise, the sum over channels may buy one with another.
    pub(crate) fn spoils(&self, before: &Node, after: &Node) -> bool {
        let level = |node: &Node, channel: usize| {
            let level = node.fit.misfit.mean_square(channel).sqrt();
            level.max(NOISE_UNDECLARED)
        };
        let worse = |c: usize| level(after, c) > SPOILT * level(before, c);
        (0..CHANNELS).any(|channel| !self.is_declared(channel) && worse(channel))
    }

    /// Guesses of all windows' starts under the nominal model.
    pub(crate) fn guesses(&self) -> Option<Vec<[f64; LOCALS]>> {
        self.posed(&[], &self.windows, |problem, values| {
            let windows = self.windows.par_iter();
            Some(windows.map(|w| start::guess(problem, values, w)).collect())
        })
    }

    /// Fits the nominal model with `hypotheses`.
    pub(crate) fn fit(
        &self,
        hypotheses: &[Hypothesis],
        starts: &[[f64; LOCALS]],
        rounds: usize,
    ) -> Option<Node> {
        self.fit_on(&self.windows, hypotheses, starts, rounds)
    }

    fn fit_on(
        &self,
        windows: &[Window],
        hypotheses: &[Hypothesis],
        starts: &[[f64; LOCALS]],
        rounds: usize,
    ) -> Option<Node> {
        let fit = self.posed(hypotheses, windows, |problem, values| {
            problem.fit(values, starts, rounds)
        })?;
        let mut hypotheses = hypotheses.to_vec();
        let mut fitted = fit.values.iter();
        for hypothesis in hypotheses.iter_mut().filter(|h| !h.is_threshold()) {
            for ((_, value), fitted) in hypothesis.values.iter_mut().zip(&mut fitted) {
                *value = *fitted;
            }
            hypothesis.keep_in_order();
        }
        Some(Node { hypotheses, fit })
    }

    /// Effects fitted to these windows alone, from the values that they have. What the windows say
    /// nothing of keeps its value.
    pub(crate) fn refitted(
        &self,
        windows: &[Window],
        hypotheses: &[Hypothesis],
    ) -> Option<Vec<Hypothesis>> {
        let starts = self.posed(&[], windows, |problem, values| {
            let windows = windows.par_iter();
            Some(
                windows
                    .map(|w| start::guess(problem, values, w))
                    .collect::<Vec<_>>(),
            )
        })?;
        let fitted = self.fit_on(windows, hypotheses, &starts, HELD_OUT)?;
        Some(fitted.hypotheses)
    }

    /// How much better (−2 ln L) `after` predicts windows that its parameters were not fitted to
    /// than `before` does: every other window is fitted, and the rest predicted, in turn.
    pub(crate) fn held_out_gain(&self, before: &Node, after: &Node) -> f64 {
        let misfits = [before, after].map(|node| {
            let folds = (0..2)
                .into_par_iter()
                .filter_map(|fold| self.held_out(node, fold));
            let folds: Vec<Misfit> = folds.collect();
            folds
                .into_iter()
                .reduce(|a, b| a.and(&b))
                .unwrap_or_default()
        });
        misfits[1].gain_over(&misfits[0])
    }

    fn held_out(&self, node: &Node, fold: usize) -> Option<Misfit> {
        let split = |own: usize| -> (Vec<Window>, Vec<[f64; LOCALS]>) {
            let all = self.windows.iter().zip(&node.fit.starts).enumerate();
            all.filter(|(i, _)| i % 2 == own)
                .map(|(_, (w, s))| (w.clone(), *s))
                .unzip()
        };
        let (fitted, starts) = split(fold);
        let learnt = self.fit_on(&fitted, &node.hypotheses, &starts, HELD_OUT)?;
        let (judged, starts) = split(1 - fold);
        self.posed(&learnt.hypotheses, &judged, |problem, _| {
            Some(problem.with_free(&[]).fit(&[], &starts, HELD_OUT)?.misfit)
        })
    }

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
            let weights = Misfit::new(&self.windows, &base).weights();
            let windows = self.windows.iter().zip(&node.fit.linear).zip(&base);
            let predicted: Vec<Vec<f64>> = windows
                .map(|((window, linear), base)| {
                    let own = linear.without_globals();
                    let normal = own.normal(window, &weights, base, &[]);
                    let step = linear::step(&[normal], 1e-9, |_, step| step);
                    own.predicted(base, &[], &step.locals[0], &[])
                })
                .collect();
            Some(Misfit::new(&self.windows, &predicted).deviance())
        })
    }

    /// The candidate, made so small that it moves what is measured no more than what is unexplained
    /// where it would make it worse. What is smaller than its probe may not show from there: what
    /// rests under a large friction says nothing of a small one.
    fn sized(&self, node: &Node, candidate: &Hypothesis) -> Option<Hypothesis> {
        let mut sized = candidate.clone();
        // a product of two numbers shows nothing of one where the other is too small
        let alone = candidate.values.len() == 1;
        for _ in 0..if alone { SHRUNK } else { 1 } {
            let mut hypotheses = node.hypotheses.clone();
            hypotheses.push(sized.clone());
            let starts = &node.fit.starts;
            let base = self.posed(&hypotheses, &self.windows, |problem, values| {
                problem.residuals(values, starts)
            })?;
            let deviance = Misfit::new(&self.windows, &base).deviance();
            let worse = deviance > node.fit.misfit.deviance() + ARRIVED;
            if candidate.is_abrupt() && !is_local(candidate) {
                return (!worse).then_some(sized);
            }
            if candidate.is_threshold() || is_local(candidate) || !worse {
                break;
            }
            let wanted = BESIDE * node.fit.misfit.worst().1.max(1.0);
            let share =
                (wanted / self.moved(node, &base).max(1e-9)).min(if alone { 0.2 } else { 1.0 });
            let (name, size) = &mut sized.values[0];
            let nothing = candidate.nothing(&self.model, name);
            *size = nothing + (*size - nothing) * share;
        }
        Some(sized)
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
        let candidate = &self.sized(node, candidate)?;
        let mut hypotheses = node.hypotheses.clone();
        hypotheses.push(candidate.clone());
        self.posed(&hypotheses, &self.windows, |problem, values| {
            let (known, starts) = (node.fit.values.len(), &node.fit.starts);
            let base = problem.residuals(values, starts)?;
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
                    own.for_each(|((_, value), step)| *value += step);
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

    /// Fits anew over ever longer heads of the windows, where a model does not reach the noise: over
    /// a long time the misfit of what slides and sticks has many valleys.
    pub(crate) fn grown(&self, node: Node) -> Node {
        if self.is_noise(&node) {
            return node;
        }
        let grow = || {
            let (mut hypotheses, mut starts) = (node.hypotheses.clone(), self.guesses()?);
            for over_s in HORIZONS_S {
                let heads = self.windows.iter();
                let heads: Vec<Window> = heads
                    .map(|window| window.head(&self.tracks[window.run], over_s))
                    .collect();
                let short = self.fit_on(&heads, &hypotheses, &starts, HELD_OUT)?;
                (hypotheses, starts) = (short.hypotheses, short.fit.starts);
            }
            self.fit(&hypotheses, &starts, FULL)
        };
        let better = |grown: &Node| grown.fit.misfit.deviance() < node.fit.misfit.deviance();
        grow().filter(better).unwrap_or(node)
    }

    /// Tries static frictions above the kinetic one: from below it nothing shows the way.
    pub(crate) fn settle_static(&self, node: Node) -> Node {
        let slip = node
            .hypotheses
            .iter()
            .position(|h| h.values.iter().any(|(name, _)| *name == STATIC));
        let Some(slip) = slip.filter(|_| !self.is_noise(&node)) else {
            return node;
        };
        let mut best = self.with_static(&node, slip, &STATIC_OVER_KINETIC);
        for closer in STATIC_CLOSER {
            let of = |name: &str| {
                let mut values = best.hypotheses[slip].values.iter();
                values.find(|(known, _)| *known == name).map(|v| v.1)
            };
            let (Some(above), Some(kinetic)) = (of(STATIC), of(KINETIC)) else {
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
        let tried = ratios.par_iter().filter_map(|ratio| {
            let mut hypotheses = node.hypotheses.clone();
            let values = &mut hypotheses[slip].values;
            let kinetic = values.iter().find(|(name, _)| *name == KINETIC)?.1;
            values
                .iter_mut()
                .filter(|(name, _)| *name == STATIC)
                .for_each(|v| v.1 = kinetic * ratio);
            self.fit(&hypotheses, &node.fit.starts, HELD_OUT)
        });
        let tried: Vec<Node> = tried.collect();
        let better = tried
            .into_iter()
            .min_by(|a, b| a.fit.misfit.deviance().total_cmp(&b.fit.misfit.deviance()));
        let better = better.filter(|b| b.fit.misfit.deviance() < node.fit.misfit.deviance());
        better.unwrap_or_else(|| node.clone())
    }

    /// Tries the sizes of commands around a threshold until none fits better.
    fn settle_threshold(&self, node: Node) -> Node {
        let (Some(track), Some(own)) = (self.tracks.first(), node.hypotheses.last()) else {
            return node;
        };
        let sizes = all_sizes(track, &self.model);
        let mut at = sizes.partition_point(|size| *size < own.values[0].1);
        let mut best = node;
        let mut stride = (sizes.len() / 8).max(1);
        loop {
            let near = [at.checked_sub(stride), Some(at + stride)];
            let near: Vec<usize> = near
                .into_iter()
                .flatten()
                .filter(|i| *i < sizes.len())
                .collect();
            let tried: Vec<(usize, Node)> = near
                .into_par_iter()
                .filter_map(|i| {
                    let mut hypotheses = best.hypotheses.clone();
                    // between one size and the next: all from here on act
                    let below = if i == 0 { 0.0 } else { sizes[i - 1] };
                    hypotheses.last_mut()?.values[0].1 = 0.5 * (below + sizes[i]);
                    Some((i, self.fit(&hypotheses, &best.fit.starts, 2)?))
                })
                .collect();
            let better = tried.into_iter().min_by(|a, b| {
                a.1.fit
                    .misfit
                    .deviance()
                    .total_cmp(&b.1.fit.misfit.deviance())
            });
            match better {
                Some((i, node)) if node.fit.misfit.deviance() < best.fit.misfit.deviance() => {
                    (at, best) = (i, node);
                }
                _ if stride > 1 => stride = stride.div_ceil(2).min(stride - 1),
                _ => return best,
            }
        }
    }
}
