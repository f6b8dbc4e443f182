//! Links on which nothing arrives while the sender goes on.

use crate::watch::silence::{Words, most_s};

/// A sender goes on that was heard within this (s).
const GOES_ON_S: f64 = 1.0;

/// What may be heard of a link, and what was.
#[derive(Debug, Clone)]
pub(super) struct Silence {
    /// How long it may be silent (s), and how long it was at the begin of the baseline.
    most_s: f64,
    begin_s: f64,
    /// When the last message arrived, or when the link was first listened for.
    last_s: Option<f64>,
    is_silent: bool,
}

impl Silence {
    /// A link that is silent for as long as it was in the runs of a baseline, and a half. Each has the times of arrival and the
    /// time of its first row (s).
    pub(super) fn new(runs: &[(Vec<f64>, f64)]) -> Self {
        let mut gaps: Vec<f64> = runs
            .iter()
            .flat_map(|(times_s, _)| times_s.windows(2).map(|pair| pair[1] - pair[0]))
            .collect();
        gaps.sort_by(f64::total_cmp);
        let usual_s = gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
        let longest_s = gaps.last().copied().unwrap_or(0.0);
        let firsts = runs
            .iter()
            .filter_map(|(times_s, begin_s)| Some(times_s.first()? - begin_s));
        Self {
            most_s: most_s(usual_s, longest_s),
            begin_s: firsts.fold(0.0, f64::max),
            last_s: None,
            is_silent: false,
        }
    }

    /// Nothing was heard.
    pub(super) fn again(&mut self) {
        (self.last_s, self.is_silent) = (None, false);
    }

    /// A message arrived (s).
    pub(super) fn arrived(&mut self, at_s: f64) {
        self.last_s = Some(self.last_s.map_or(at_s, |own| own.max(at_s)));
    }

    /// Whether it fell silent or came back, at a time (s) up to which the sender was heard `sender_s` last; what is said of it.
    pub(super) fn look(&mut self, name: &str, now_s: f64, sender_s: f64) -> Option<Words> {
        let last_s = *self.last_s.get_or_insert(now_s + self.begin_s);
        let silent_s = now_s - last_s;
        let is_over = silent_s > self.most_s;
        let goes_on = now_s - sender_s < GOES_ON_S && sender_s - last_s > self.most_s / 2.0;
        match (self.is_silent, is_over) {
            (false, true) if goes_on => {
                self.is_silent = true;
                Some((
                    "link_silent",
                    format!("link {name}: no message for {silent_s:.1} s while the sender goes on"),
                    "look at the network between them and at what the sender publishes",
                ))
            }
            (true, false) => {
                self.is_silent = false;
                Some((
                    "link_back",
                    format!("link {name}: messages come again"),
                    "nothing to do",
                ))
            }
            _ => None,
        }
    }
}
