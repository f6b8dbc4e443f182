//! The delays of one link: since when they are others, and how large they are now.

use std::collections::VecDeque;

use super::usual::{FLOOR_S, Median, Usual, median};
use crate::watch::alarm::State;

/// How long messages are kept (s), and how many at most.
const KEPT_S: f64 = 30.0;
const MOST_KEPT: usize = 2048;
/// Of onsets before the last so many messages, only every so many-th is looked at.
const DENSE: f64 = 80.0;
const SPARSE: f64 = 8.0;
/// Messages since an onset, at least.
const LEAST: usize = 5;
/// Time between two looks (s).
const LOOK_S: f64 = 0.25;
/// Deviation of the mean score that a change leads to.
const PLAUSIBLE: f64 = 1.5;
/// A change that holds for so long (s), with so many messages, is confirmed.
const HOLD_S: f64 = 5.0;
const HOLD: usize = 2 * LEAST;
/// The last messages that say whether a change still holds (s), and how clearly they do, in halves of 95 % intervals.
const LAST_S: [f64; 3] = [0.5, 1.0, 2.0];
const CLEARLY: f64 = 1.8;

/// A message that arrived.
#[derive(Debug, Clone, Copy)]
struct ArrivedMessage {
    t_sent_s: f64,
    delay_s: f64,
    score: f64,
}

/// A change that was raised.
#[derive(Debug, Clone, Copy)]
struct Raised {
    onset_s: f64,
    now: Median,
    nats: f64,
}

/// What is said of a link.
#[derive(Debug, Clone)]
pub(super) struct Said {
    pub(super) state: State,
    pub(super) onset_s: f64,
    pub(super) now: Median,
    pub(super) was_s: f64,
    pub(super) was_ci95_s: [f64; 2],
    /// Bayes factor between a change and none (nats).
    pub(super) nats: f64,
}

/// One link.
#[derive(Debug, Clone)]
pub(super) struct Delays {
    of_baseline: Usual,
    usual: Usual,
    heard: VecDeque<ArrivedMessage>,
    raised: Option<Raised>,
    next_s: f64,
    /// What a factor has to reach (nats).
    least: f64,
}

impl Delays {
    /// A link whose delays in the baseline are `usual`; a factor has to reach `least` nats.
    pub(super) fn new(usual: Usual, least: f64) -> Self {
        Self {
            of_baseline: usual.clone(),
            usual,
            heard: VecDeque::new(),
            raised: None,
            next_s: f64::NEG_INFINITY,
            least,
        }
    }

    /// Nothing was heard.
    pub(super) fn again(&mut self) {
        *self = Self::new(self.of_baseline.clone(), self.least);
    }

    /// Hears a message; what is said of it.
    pub(super) fn hear(&mut self, t_sent_s: f64, delay_s: f64) -> Option<Said> {
        let score = self.usual.score(delay_s);
        self.heard.push_back(ArrivedMessage {
            t_sent_s,
            delay_s,
            score,
        });
        let is_old = |own: &ArrivedMessage| own.t_sent_s < t_sent_s - KEPT_S;
        while self.heard.len() > MOST_KEPT || self.heard.front().is_some_and(is_old) {
            self.heard.pop_front();
        }
        if t_sent_s < self.next_s {
            return None;
        }
        self.next_s = t_sent_s + LOOK_S;
        match self.raised {
            None => self.look(),
            Some(raised) => self.follow(raised, t_sent_s),
        }
    }

    /// Looks for a change.
    fn look(&mut self) -> Option<Said> {
        let (nats, place) = self.best()?;
        if nats < self.least {
            return None;
        }
        let onset_s = self.heard.get(place)?.t_sent_s;
        let now = self.since(onset_s)?;
        let is_felt = (now.at_s - self.usual.median_s).abs() > FLOOR_S;
        let raised = Raised { onset_s, now, nats };
        is_felt.then(|| {
            self.raised = Some(raised);
            self.said(raised, State::Raised)
        })
    }

    /// The largest Bayes factor (nats) between a change since one of the messages and none, and the place of that message.
    fn best(&self) -> Option<(f64, usize)> {
        let (mut sum, mut count) = (0.0, 0.0);
        let mut best: Option<(f64, usize)> = None;
        for (place, own) in self.heard.iter().enumerate().rev() {
            (sum, count) = (sum + own.score, count + 1.0);
            let is_due = count <= DENSE || count % SPARSE == 0.0;
            if count < LEAST as f64 || !is_due {
                continue;
            }
            let nats = factor(sum / count, self.usual.variance(count));
            if best.is_none_or(|(most, _)| nats > most) {
                best = Some((nats, place));
            }
        }
        best
    }

    /// The delay since an onset (s).
    fn since(&self, onset_s: f64) -> Option<Median> {
        median(self.delays_s(onset_s), self.usual.dispersion)
    }

    fn delays_s(&self, from_s: f64) -> Vec<f64> {
        let own = self.heard.iter().filter(|own| own.t_sent_s >= from_s);
        own.map(|own| own.delay_s).collect()
    }

    /// Whether a change that was raised holds, and for how long it does.
    fn follow(&mut self, raised: Raised, now_s: f64) -> Option<Said> {
        let now = self.since(raised.onset_s)?;
        let raised = Raised { now, ..raised };
        self.raised = Some(raised);
        if self.is_gone(raised, now_s) {
            self.heard.clear();
            self.raised = None;
            return Some(self.said(raised, State::Withdrawn));
        }
        let messages = self.delays_s(raised.onset_s).len();
        if now_s - raised.onset_s < HOLD_S || messages < HOLD {
            return None;
        }
        let said = self.said(raised, State::Confirmed);
        self.usual = self.usual.moved(raised.now, messages);
        self.heard.clear();
        self.raised = None;
        Some(said)
    }

    /// Whether the last messages are clearly nearer to the usual delay than to that of a change.
    fn is_gone(&self, raised: Raised, now_s: f64) -> bool {
        let by_s = raised.now.at_s - self.usual.median_s;
        let last = self.heard.iter().rev().take(HOLD).map(|own| own.t_sent_s);
        let from_s = last.fold(now_s, f64::min);
        let mut windows = LAST_S.iter().filter_map(|own_s| {
            let delays_s = self.delays_s(from_s.min(now_s - own_s).max(raised.onset_s));
            median(delays_s, self.usual.dispersion)
        });
        windows.any(|own| {
            let apart_s = (own.at_s - self.usual.median_s) * by_s.signum();
            apart_s + CLEARLY * own.half_s < by_s.abs() / 2.0
        })
    }

    fn said(&self, raised: Raised, state: State) -> Said {
        Said {
            state,
            onset_s: raised.onset_s,
            now: raised.now,
            was_s: self.usual.median_s,
            was_ci95_s: self.usual.interval_s(),
            nats: raised.nats,
        }
    }
}

/// Bayes factor (nats) between a mean that changed by a plausible size and one that did not, where a mean strays with this variance.
fn factor(mean: f64, variance: f64) -> f64 {
    let plausible = PLAUSIBLE * PLAUSIBLE;
    let share = plausible / (plausible + variance);
    mean * mean * share / (2.0 * variance) - (plausible / variance).ln_1p() / 2.0
}
