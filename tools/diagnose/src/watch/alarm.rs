//! A change that was raised: when it is diagnosed, and when it is gone.

use super::robot::Found;

/// Rows that a diagnosis needs (s); each next one has twice as many.
const FIRST_S: f64 = 10.0;
/// How often it is diagnosed.
const MOST: u32 = 3;
/// Looks without it after which it is gone.
const GONE: u32 = 6;

/// How sure a change is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The rows say so; a diagnosis is still due.
    Raised,
    /// A diagnosis says so, too.
    Confirmed,
    /// It does not hold.
    Withdrawn,
}

impl State {
    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Confirmed => "confirmed",
            Self::Withdrawn => "withdrawn",
        }
    }
}

/// A change that was raised.
pub(super) struct Alarm {
    pub(super) found: Found,
    /// When it was raised (s).
    pub(super) raised_s: f64,
    /// Looks in a row without it.
    pub(super) missed: u32,
    /// The diagnosis that was asked for and has not answered.
    pub(super) asked: Option<u64>,
    times: u32,
}

impl Alarm {
    pub(super) fn new(found: Found, raised_s: f64) -> Self {
        Self {
            found,
            raised_s,
            missed: 0,
            asked: None,
            times: 0,
        }
    }

    /// Whether a diagnosis is due.
    pub(super) fn is_due(&self, now_s: f64) -> bool {
        let least_s = FIRST_S * f64::from(1_u32 << self.times.min(MOST));
        self.asked.is_none() && self.times < MOST && now_s - self.found.onset_s >= least_s
    }

    /// A diagnosis is made.
    pub(super) fn asks(&mut self, number: u64) {
        self.asked = Some(number);
        self.times += 1;
    }

    /// Whether no diagnosis follows.
    pub(super) fn is_last(&self) -> bool {
        self.times >= MOST
    }

    /// Whether rows do not say so any more.
    pub(super) fn is_gone(&self) -> bool {
        self.missed >= GONE
    }
}
