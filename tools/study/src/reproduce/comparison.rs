//! The reproduction as a whole: assumptions, comparison with the paper, extensions, and the runs.

use serde::{Deserialize, Serialize};

use super::assumptions::{Assumption, assumptions};
use super::causes::{Explanation, explain};
use super::extensions::{Extension, extensions};
use super::paper_runs::PaperRuns;
use super::recorded_run::RecordedRun;
use super::row::PaperRow;
use crate::StudyError;

/// Paper against computed: the answer of `slipstream reproduce`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Version of this format.
    pub format: u32,
    /// What explains the final positions that the paper prints.
    pub explanation: Explanation,
    /// What the paper leaves open.
    pub assumptions: Vec<Assumption>,
    /// Paper against computed.
    pub rows: Vec<PaperRow>,
    /// Beyond the paper: turns, and a floor whose friction changes, under every torque limit.
    #[serde(rename = "beyond")]
    pub extensions: Vec<Extension>,
}

/// The comparison, and the runs behind it for figures.
#[derive(Debug, Clone)]
pub struct Reproduction {
    /// Paper against computed.
    pub comparison: Comparison,
    /// The paper's runs.
    pub runs: PaperRuns,
    /// The figure eight under the fixed limit: by the paper's law and by computed torque.
    pub figure_eight: [RecordedRun; 2],
}

/// Runs all experiments.
///
/// # Errors
/// When a run fails.
pub fn reproduce() -> Result<Reproduction, StudyError> {
    let runs = PaperRuns::new(&[])?;
    let rows = runs.rows()?;
    let turning =
        |law| RecordedRun::of_experiment("figure_eight", "inner", &[("control.law", law)]);
    Ok(Reproduction {
        comparison: Comparison {
            format: 1,
            explanation: explain()?,
            assumptions: assumptions()?,
            rows,
            extensions: extensions()?,
        },
        runs,
        figure_eight: [turning("paper")?, turning("computed_torque")?],
    })
}
