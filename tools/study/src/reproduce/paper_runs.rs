//! The paper's four runs: one robot and the platoon, each without and with the torque limit.

use super::recorded_run::RecordedRun;
use super::row::PaperRow;
use super::{limits, platoon, single};
use crate::StudyError;

/// The paper's runs; pairs are [without, with] the torque limit.
#[derive(Debug, Clone)]
pub struct PaperRuns {
    /// Section 3.
    pub single: [RecordedRun; 2],
    /// Section 4.
    pub platoon: [RecordedRun; 2],
}

impl PaperRuns {
    /// Runs the paper's experiments with `keys` set to these values in place of the assumed ones.
    ///
    /// # Errors
    /// When a run fails.
    pub fn new(keys: &[(&str, &str)]) -> Result<Self, StudyError> {
        let run = |name, limit| RecordedRun::of_experiment(name, limit, keys);
        Ok(Self {
            single: [run("single", "none")?, run("single", "inner")?],
            platoon: [run("platoon", "none")?, run("platoon", "outer")?],
        })
    }

    /// Paper against computed, except for the asymmetries, which need runs of their own.
    ///
    /// # Errors
    /// A robot that cannot be controlled.
    pub fn rows(&self) -> Result<Vec<PaperRow>, StudyError> {
        let mut rows = limits::rows(&self.single[0].experiment)?;
        rows.extend(single::rows(&self.single));
        rows.extend(platoon::rows(&self.platoon));
        Ok(rows)
    }
}
