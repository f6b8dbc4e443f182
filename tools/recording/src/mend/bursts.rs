//! Rows that arrive together after a pause: their stamps are times of arrival, not of measurement.

use super::scale::{MOST_FAULTS, intervals};
use crate::rows::Rows;

/// A pause is longer than so many usual intervals.
const PAUSE: f64 = 3.0;
/// Rows of a burst follow each other within this part of the usual interval.
const TOGETHER: f64 = 0.25;
/// A stream whose intervals differ by more than this part of the usual one (median) has no usual interval: events
/// come when they come.
const REGULAR: f64 = 0.4;
/// Fewest rows that say that rows arrive in bursts: one or two are late for other reasons.
const FEWEST_ROWS: usize = 3;

/// The rows with a stamp that says nothing.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Bursts {
    /// The rows, ascending. The last one of each burst is not among them: it was measured just before it came.
    pub(crate) rows: Vec<usize>,
    /// Time of the last row of each burst (s).
    pub(crate) times_s: Vec<f64>,
}

/// The rows of bursts; empty where there are too few to say so.
pub(crate) fn bursts(rows: &Rows<'_>) -> Bursts {
    let Some([interval_s, deviation]) = intervals(rows) else {
        return Bursts::default();
    };
    if deviation > REGULAR {
        return Bursts::default();
    }
    let mut search = BurstSearch {
        interval_s,
        row: 0,
        last_s: None,
        missing: 0,
        found: Bursts::default(),
    };
    rows.visit_times(&mut |times| times.iter().for_each(|t_s| search.add(*t_s)));
    let found = search.found;
    if found.rows.len() < FEWEST_ROWS {
        return Bursts::default();
    }
    found
}

struct BurstSearch {
    interval_s: f64,
    row: usize,
    last_s: Option<f64>,
    /// Rows that the pause before held back and that did not come yet.
    missing: usize,
    found: Bursts,
}

impl BurstSearch {
    fn add(&mut self, t_s: f64) {
        let Some(last_s) = self.last_s.replace(t_s) else {
            self.row += 1;
            return;
        };
        let steps = (t_s - last_s) / self.interval_s;
        if steps > PAUSE {
            self.missing = steps.ceil() as usize;
        } else if self.missing > 0 && steps < TOGETHER && self.found.rows.len() < MOST_FAULTS {
            self.missing -= 1;
            let before = self.row - 1;
            // a burst goes on, or begins
            if self.found.times_s.last() != Some(&last_s) {
                self.found.times_s.push(t_s);
            } else if let Some(last) = self.found.times_s.last_mut() {
                *last = t_s;
            }
            self.found.rows.push(before);
        } else {
            self.missing = 0;
        }
        self.row += 1;
    }
}
