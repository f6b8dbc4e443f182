//! One machine before the judge: its predictions window by window, without and with what was found.

use rayon::prelude::*;

use super::budget::{Squares, budget, culprit};
use super::passing::Culprit;
use super::score::{GYRO, HEADING, PLACE, POSE, QUANTITIES, Score, name};
use super::starts::known;
use super::worse::worse;
use crate::answer::{Budget, HeldOut, HeldOutChannel};

/// Channels that make up the total: the pose, or wheels and gyro where there is none.
const OF_POSE: [usize; 3] = [POSE, POSE + 1, POSE + 2];
const OF_OTHERS: [usize; 3] = [0, 1, GYRO];

/// One machine before the judge.
pub(crate) struct Predictions {
    pub(crate) robot: String,
    /// All windows before and after.
    pub(super) before: Score,
    pub(super) after: Score,
    /// Begin and end (s) of each window.
    pub(super) spans_s: Vec<[f64; 2]>,
    /// What each scores, before and after.
    scores: [Vec<Score>; 2],
    /// Findings that fitted best and were not published, for they predict worse.
    pub(crate) refused: Vec<String>,
}

/// What every subset of the effects that were found (as bits) scores on some windows, all fitted together.
pub(crate) struct Worth {
    pub(crate) names: Vec<&'static str>,
    scores: Vec<Score>,
}

impl Worth {
    /// What every subset of `names` scores on every window, by `scores` of those that are left out; where all together
    /// do not know a start, the window says nothing.
    pub(crate) fn new(
        names: Vec<&'static str>,
        scores: impl Fn(&[&'static str]) -> Vec<Score> + Sync,
    ) -> Self {
        let subsets = (0..1_usize << names.len()).into_par_iter().map(|subset| {
            let all = names.iter().enumerate();
            let left_out = all.filter(|(i, _)| subset >> i & 1 == 0);
            scores(&left_out.map(|(_, name)| *name).collect::<Vec<_>>())
        });
        let windows: Vec<Vec<Score>> = subsets.collect();
        let starts = windows.last().map_or_else(Vec::new, |own| known(own));
        let sum = |own: &Vec<Score>| Score::of_all(&kept(own, &starts));
        Self {
            scores: windows.iter().map(sum).collect(),
            names,
        }
    }

    /// Mean square error of a quantity for every subset; `None` where it was not measured.
    fn squares(&self, quantity: usize) -> Option<Vec<f64>> {
        let all = self.scores.iter();
        all.map(|own| own.mean_square(quantity)).collect()
    }
}

/// Those of which `which` says so.
fn kept<T: Copy>(all: &[T], which: &[bool]) -> Vec<T> {
    let pairs = all.iter().zip(which);
    pairs.filter(|(_, is)| **is).map(|(own, _)| *own).collect()
}

impl Predictions {
    /// The windows of a machine: begin and end (s), and what each scores before and after.
    pub(crate) fn new(robot: &str, spans_s: Vec<[f64; 2]>, scores: [Vec<Score>; 2]) -> Self {
        // a window whose start no model knows says nothing of them
        let starts = known(&scores[1]);
        let spans_s = kept(&spans_s, &starts);
        let scores = scores.map(|own| kept(&own, &starts));
        let [before, after] = &scores;
        Self {
            robot: robot.to_owned(),
            before: Score::of_all(before),
            after: Score::of_all(after),
            spans_s,
            scores,
            refused: Vec::new(),
        }
    }

    /// How many windows anything was measured in.
    pub(super) fn seen(&self) -> usize {
        let has = |score: &&Score| (0..QUANTITIES).any(|quantity| score.has(quantity));
        self.scores[1].iter().filter(has).count()
    }

    /// What all windows score after.
    pub(crate) fn after(&self) -> Score {
        self.after
    }

    /// Sets that the error of another recording is expected; if something changed since, at least that.
    pub(crate) fn expect_as(&mut self, other: &Score, has_changed: bool) {
        self.after.expect_as(other, has_changed);
        let windows = self.scores[1].iter_mut();
        windows.for_each(|score| score.expect_as(other, has_changed));
    }

    /// Begin, end (s) and score of each window after.
    pub(super) fn windows(&self) -> impl Iterator<Item = (&[f64; 2], &Score)> {
        self.spans_s.iter().zip(&self.scores[1])
    }

    /// What makes predictions worse than those of the nominal model; `None` where they are not.
    pub(crate) fn culprit(&self, worth: impl FnOnce() -> Worth) -> Option<Culprit> {
        let [before, after] = &self.scores;
        let quantity = worse(before, after).into_iter().max()?;
        let worth = worth();
        let place = culprit(worth.names.len(), &worth.squares(quantity)?)?;
        Some(Culprit {
            effect: worth.names[place],
            quantity: name(quantity),
        })
    }

    /// The predictions as they are answered, over `horizon_s`; `unit` is that of each channel.
    pub(crate) fn held_out(&self, horizon_s: f64, unit: &dyn Fn(usize) -> &'static str) -> HeldOut {
        let Self { before, after, .. } = self;
        let channels = (0..PLACE).filter_map(|channel| {
            let root = |score: &Score| score.mean_square(channel).map(f64::sqrt);
            Some(HeldOutChannel {
                robot: self.robot.clone(),
                channel: name(channel).to_owned(),
                nrmse_before: before.level(&[channel])?,
                nrmse_after: after.level(&[channel])?,
                unit: unit(channel),
                rms_before: root(before)?,
                rms_after: root(after)?,
                rms_expected: after.expected(channel)?.sqrt(),
            })
        });
        let total: &[usize] = if OF_POSE.iter().any(|channel| before.has(*channel)) {
            &OF_POSE
        } else {
            &OF_OTHERS
        };
        HeldOut {
            channels: channels.collect(),
            nrmse_before: before.level(total).unwrap_or(0.0),
            nrmse_after: after.level(total).unwrap_or(0.0),
            horizon_s,
        }
    }

    /// Where the error of position and heading went.
    pub(crate) fn budgets(&self, worth: &Worth) -> Vec<Budget> {
        let of = |(unit, quantity): (&'static str, usize)| {
            let squares = Squares {
                robot: &self.robot,
                unit,
                held_out: [
                    self.before.mean_square(quantity)?,
                    self.after.mean_square(quantity)?,
                ],
                sensor: self.after.sensor(quantity)?,
                expected: self.after.expected(quantity)?,
            };
            budget(&squares, &worth.names, &worth.squares(quantity)?)
        };
        let both = [("m", PLACE), ("rad", HEADING)];
        both.into_iter().filter_map(of).collect()
    }
}
