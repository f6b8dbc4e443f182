//! What is looked at: tracks, windows and the nominal model, and models fitted to them.

use std::sync::Arc;

use rayon::prelude::*;
use slipstream_bus::RobotModel;
use slipstream_sim::effects::{Info, When};
use slipstream_sim::{CommandKind, ListedEffect, read_effects};

use crate::windows::fit::{Fit, Free, Problem};
use crate::windows::hypothesis::{Hypothesis, changes_commands_over_time, slides};
use crate::windows::law::Law;
use crate::windows::misfit::Misfit;
use crate::windows::score;
use crate::windows::simulate::is_exact_at_any_step;
use crate::windows::start;
use crate::windows::track::{CHANNELS, ROUNDING, Sensor, Track};
use crate::windows::window::{LOCALS, Window, cut_all, cut_fitted};
use crate::windows::work::Work;

/// Longest step of a simulation (s): where wheels slip or gears have play, where they do not, and
/// where they turn exactly as told.
const SHORT_STEP_S: f64 = 2e-3;
const STEP_S: f64 = 4e-3;
const LONG_STEP_S: f64 = 0.02;

/// How often all windows are simulated before a search goes on from one model, the best that
/// leads on, and before it stops.
const NARROW: f64 = 4000.0;
const BUDGET: f64 = 8000.0;
/// What is shorter may be searched longer (s).
const SHORT_S: f64 = 30.0;

/// Level (deviations) that counts as noise, where the noise is declared and where it is not.
const NOISE: f64 = 1.12;
const NOISE_UNDECLARED: f64 = 1.5;

/// Level (deviations) at which nothing more can be explained.
const NOTHING_LEFT: f64 = 1.05;

/// Growth of the level of a channel that spoils it.
pub(crate) const SPOILT: f64 = 1.15;

/// Rounds of a fit to a part of the windows, from the fit to all.
pub(crate) const HELD_OUT: usize = 6;

/// Rounds of a fit to the end.
pub(crate) const FULL: usize = 30;

/// The runs of one machine, cut into windows, and its nominal model.
pub(crate) struct Bench {
    pub(crate) tracks: Vec<Track>,
    pub(crate) windows: Vec<Window>,
    pub(crate) model: RobotModel,
    /// A force outside of the catalogue that acts beside all effects.
    pub(crate) law: Option<Law>,
    /// What was simulated so far.
    pub(crate) work: Arc<Work>,
}

/// The nominal model with these effects, fitted.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) hypotheses: Vec<Hypothesis>,
    pub(crate) fit: Fit,
}

/// Effects as the plant takes them, and which of their numbers are fitted from which values.
struct Setting {
    list: Vec<ListedEffect<f64>>,
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

/// Every other one of what windows have, from this one on.
pub(crate) fn every_other<T: Clone>(all: &[T], from: usize) -> Vec<T> {
    all.iter().skip(from).step_by(2).cloned().collect()
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

    /// Standard deviation of the sensor of a channel, in its unit.
    pub(crate) fn deviation(&self, channel: usize) -> f64 {
        let mut series = self.tracks[0].series.iter();
        let own = series.find_map(|series| {
            let part = channel.checked_sub(series.sensor.channel())?;
            (part < series.sensor.width()).then(|| series.deviation[part])
        });
        own.unwrap_or(1.0)
    }

    /// Whether wheels turn as they are told, so that no force can be missing, but a motion.
    pub(crate) fn lacks_motion(&self) -> bool {
        let mut tracks = self.tracks.iter();
        tracks.any(|track| track.kind() == CommandKind::Speed)
    }

    fn step_s(&self, list: &[ListedEffect<f64>]) -> f64 {
        let has = |such: fn(&Info) -> bool| list.iter().any(|(info, _)| such(info));
        let slips = has(|info| slides(info) || info.acts == When::Apart);
        let lags = has(changes_commands_over_time);
        let kind = self.tracks.first().map_or(CommandKind::Torque, Track::kind);
        if is_exact_at_any_step(kind, slips, lags) {
            LONG_STEP_S
        } else if slips {
            SHORT_STEP_S
        } else {
            STEP_S
        }
    }

    /// Whether so much was simulated that a search has to go on from one model: the best that leads on.
    pub(crate) fn is_narrow(&self) -> bool {
        self.times() > NARROW
    }

    /// Whether so much was simulated that a search has to come to its end.
    pub(crate) fn is_spent(&self) -> bool {
        self.times() > BUDGET
    }

    /// How often all windows were simulated; what is short counts as if it were longer.
    fn times(&self) -> f64 {
        let lengths = self.windows.iter().map(|w| w.to_s - w.from_s);
        self.work.so_far_s() / lengths.sum::<f64>().max(SHORT_S)
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
            law: self.law.as_ref(),
            work: &self.work,
        };
        solve(&problem, &setting.values)
    }

    /// The same cut anew, so that no window begins in one of these times (s).
    pub(crate) fn avoiding(&self, times_s: &[[f64; 2]]) -> Self {
        self.over(cut_fitted(&self.tracks, times_s))
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

    /// Whether what `node` leaves is all that the declared noise is, and nothing more.
    pub(crate) fn is_all(&self, node: &Node) -> bool {
        let level = |channel: usize| node.fit.misfit.mean_square(channel).sqrt();
        self.knows_noise() && (0..CHANNELS).all(|channel| level(channel) < NOTHING_LEFT)
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

    /// Whether the recording says how noisy each of its channels is.
    pub(crate) fn knows_noise(&self) -> bool {
        (0..CHANNELS).all(|channel| self.is_declared(channel))
    }

    /// Deviations of the encoders by which two integrators may differ: a count, where the deviation is
    /// that of its rounding; one where the noise is not known.
    pub(crate) fn count(&self) -> f64 {
        let counts = self
            .tracks
            .iter()
            .any(|t| t.of(Sensor::WheelAngle).is_some());
        if counts && self.knows_noise() {
            1.0 / ROUNDING
        } else {
            1.0
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

    /// Whether `after`, which does not reach the noise, predicts much worse than `before`, over the
    /// whole of the recordings; or is, where noise is not declared, much further off in a channel,
    /// fitted or predicted: the sum over channels may buy one with another.
    pub(crate) fn spoils(&self, before: &Node, after: &Node) -> bool {
        let unknown: Vec<usize> = (0..CHANNELS).filter(|c| !self.is_declared(*c)).collect();
        if unknown.is_empty() && self.is_noise(after) {
            return false;
        }
        let level = |misfit: &Misfit, c: usize| misfit.mean_square(c).sqrt().max(NOISE_UNDECLARED);
        let worse = |before: &Misfit, after: &Misfit| {
            let mut channels = unknown.iter();
            channels.any(|c| level(after, *c) > SPOILT * level(before, *c))
        };
        if worse(&before.fit.misfit, &after.fit.misfit) {
            return true;
        }
        let all = cut_all(&self.tracks, &[]);
        let predicted = |node: &Node| score::prediction(self, &all, &node.hypotheses);
        let [before, after] = [before, after].map(predicted);
        worse(&before, &after) || score::total(&after) > SPOILT * score::total(&before)
    }

    /// Guesses of these windows' starts under the nominal model.
    pub(crate) fn guesses(&self, windows: &[Window]) -> Option<Vec<[f64; LOCALS]>> {
        self.posed(&[], windows, |problem, values| {
            let windows = windows.par_iter();
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

    pub(crate) fn fit_on(
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

    /// The same cut into these windows.
    pub(crate) fn over(&self, windows: Vec<Window>) -> Self {
        Self {
            tracks: self.tracks.clone(),
            windows,
            model: self.model.clone(),
            law: self.law.clone(),
            work: Arc::clone(&self.work),
        }
    }

    /// Every other window, from this one on, and the node as it begins there.
    pub(crate) fn half(&self, node: &Node, from: usize) -> (Self, Node) {
        let mut own = node.clone();
        own.fit.starts = every_other(&node.fit.starts, from);
        (self.over(every_other(&self.windows, from)), own)
    }

    /// The same under a force outside of the catalogue.
    pub(crate) fn under(&self, law: Option<Law>) -> Self {
        Self {
            law,
            ..self.over(self.windows.clone())
        }
    }

    /// Effects fitted to the windows, from the values that they have. What the windows say nothing
    /// of keeps its value.
    pub(crate) fn refitted(&self, hypotheses: &[Hypothesis]) -> Option<Vec<Hypothesis>> {
        let starts = self.begun(hypotheses)?;
        Some(self.fit(hypotheses, &starts, HELD_OUT)?.hypotheses)
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
}
