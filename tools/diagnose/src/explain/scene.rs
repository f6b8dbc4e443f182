//! What the figures of one machine are drawn from.

use super::calibration::Calibration;
use super::claim::Claim;
use super::drive::DriveFit;
use super::prediction::{Errors, Predictor};
use crate::judge::QUANTITIES;
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::from_wheels::FromWheels;

/// What is drawn.
pub(crate) struct Scene<'a> {
    pub(crate) robot: &'a str,
    pub(crate) machine: &'a FromWheels,
    pub(crate) predictors: Vec<Predictor<'a>>,
    pub(crate) excluded: &'a [String],
    pub(crate) claims: &'a [Claim],
    /// Number of the first claim among all findings.
    pub(crate) first_finding: usize,
    pub(crate) calibration: Option<&'a Calibration>,
    pub(crate) drive: Option<&'a DriveFit>,
    /// Commands and wheels of all runs.
    pub(crate) driven: Option<&'a CommandToWheels>,
    /// The same with runs from before.
    pub(crate) joint_drive: Option<&'a CommandToWheels>,
    /// Parameters without and with what was found.
    pub(crate) nominal: &'a [f64],
    pub(crate) fitted: &'a [f64],
    pub(crate) errors: &'a [[Errors; 2]],
    pub(crate) deviations: &'a [[f64; QUANTITIES]],
    /// The nominal value of a claim's parameter.
    pub(crate) nominal_of: &'a dyn Fn(&Claim, &str) -> Option<f64>,
}

/// At most so many windows, at equal distances.
pub(super) fn some_windows(predictor: &Predictor<'_>, most: usize) -> Vec<[f64; 2]> {
    let all = predictor.windows();
    let stride = all.len().div_ceil(most.max(1)).max(1);
    all.into_iter().step_by(stride).collect()
}
