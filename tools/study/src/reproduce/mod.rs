//! The paper's experiments run again, and every number that it prints beside what comes out.

mod asymmetry;
mod beyond;
mod limits;
mod platoon;
mod printed;
mod report;
mod row;
mod single;
mod trial;

pub use beyond::Beyond;
pub use report::page;
pub use row::{Row, TOLERANCE};
pub use trial::Trial;

use serde::Serialize;
use slipstream_launch::{Request, resolve};

use crate::StudyError;

/// Something that the paper leaves open, as the files of its experiments have it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Assumption {
    /// The experiment whose file has it.
    pub experiment: &'static str,
    /// Name, keys and reason.
    #[serde(flatten)]
    pub assumed: slipstream_launch::Assumption,
}

/// Everything that came out.
#[derive(Debug, Clone, Serialize)]
pub struct Reproduction {
    format: u32,
    /// What the paper leaves open.
    pub assumptions: Vec<Assumption>,
    /// Paper against computed.
    pub rows: Vec<Row>,
    /// Beyond the paper: turning, and a floor that changes, under every torque limit.
    pub beyond: Vec<Beyond>,
    /// The runs behind them: single and platoon, each without and with the limit.
    #[serde(skip)]
    pub trials: Trials,
    /// The figure eight under the fixed limit, by the paper's law and by computed torque.
    #[serde(skip)]
    pub figure_eight: [Trial; 2],
}

/// The runs: [without, with] the limit.
#[derive(Debug, Clone)]
pub struct Trials {
    /// Section 3.
    pub single: [Trial; 2],
    /// Section 4.
    pub platoon: [Trial; 2],
}

impl Trials {
    /// Runs the paper's experiments with some keys set to other values than it is assumed.
    ///
    /// # Errors
    /// When a run fails.
    pub fn run(other: &[(&str, &str)]) -> Result<Self, StudyError> {
        let trial = |name, limit| Trial::with(name, limit, other);
        Ok(Self {
            single: [trial("single", "none")?, trial("single", "inner")?],
            platoon: [trial("platoon", "none")?, trial("platoon", "outer")?],
        })
    }

    /// Paper against computed, but for the asymmetries, which need runs of their own.
    ///
    /// # Errors
    /// A robot that cannot be controlled.
    pub fn rows(&self) -> Result<Vec<Row>, StudyError> {
        let mut rows = limits::rows(&self.single[0].experiment)?;
        rows.extend(single::rows(&self.single));
        rows.extend(platoon::rows(&self.platoon));
        Ok(rows)
    }
}

/// What the files of the paper's experiments assume.
///
/// # Errors
/// A file that cannot be used.
pub fn assumptions() -> Result<Vec<Assumption>, StudyError> {
    let mut all = Vec::new();
    for experiment in ["platoon", "single"] {
        let request = Request {
            experiment: Some(experiment.to_owned()),
            ..Request::default()
        };
        let assumed = resolve(&request)?.assumptions.into_iter();
        all.extend(assumed.map(|assumed| Assumption {
            experiment,
            assumed,
        }));
    }
    Ok(all)
}

/// Runs everything.
///
/// # Errors
/// When a run fails.
pub fn reproduce() -> Result<Reproduction, StudyError> {
    let trials = Trials::run(&[])?;
    let mut rows = trials.rows()?;
    rows.extend(asymmetry::rows()?);
    let turning = |law| Trial::with("figure_eight", "inner", &[("control.law", law)]);
    Ok(Reproduction {
        format: 1,
        assumptions: assumptions()?,
        rows,
        beyond: beyond::table()?,
        trials,
        figure_eight: [turning("paper")?, turning("computed_torque")?],
    })
}
