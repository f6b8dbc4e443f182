//! Which part of which trial a report is about.

use serde::{Deserialize, Serialize};
use slipstream_bus::Shard;

/// The trial that was asked for, and which shard of it this is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrialPart {
    /// How the cases are chosen; null for existing labels.
    pub plan: Option<String>,
    /// Seed of all random numbers; null for existing labels.
    pub seed: Option<u64>,
    /// The effect that all cases have, if one was asked for.
    pub effect: Option<String>,
    /// SHA-256 of the labels; null for a plan.
    pub labels: Option<String>,
    /// Number of cases of the whole trial.
    pub cases: usize,
    /// Effects left out of every catalogue.
    pub without: Vec<String>,
    /// The program that diagnoses; null for this one.
    pub with: Option<String>,
    /// Time limit of one diagnosis (s).
    pub limit_s: u64,
    /// Which part of the cases this is.
    pub shard: Shard,
}

impl TrialPart {
    /// Whether both are parts of one trial.
    pub fn is_of_the_trial_of(&self, other: &Self) -> bool {
        let shard = self.shard;
        Self {
            shard,
            ..other.clone()
        } == *self
    }

    /// The whole trial.
    #[must_use]
    pub fn whole(&self) -> Self {
        Self {
            shard: Shard::WHOLE,
            ..self.clone()
        }
    }

    /// Number of cases of this part.
    pub fn count(&self) -> usize {
        let Shard { index, of } = self.shard;
        match self.cases.checked_sub(index) {
            Some(beyond_first) => beyond_first / of.max(1) + 1,
            None => 0,
        }
    }
}
