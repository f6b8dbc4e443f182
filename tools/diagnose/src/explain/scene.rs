//! What the figures of one machine are drawn from.

use super::claim::Claim;
use super::errors::Errors;
use super::fitted::Fitted;
use super::prediction::Predictor;
use crate::judge::QUANTITIES;
use crate::model::from_wheels::FromWheels;

/// What is drawn.
pub(crate) struct Scene<'a> {
    pub(crate) robot: &'a str,
    pub(crate) machine: &'a FromWheels,
    pub(crate) predictors: Vec<Predictor<'a>>,
    /// What was fitted to the runs of today, and to all runs.
    pub(crate) own: Fitted<'a>,
    pub(crate) all: Fitted<'a>,
    /// Fitted parameters with what was found alone.
    pub(crate) at: Vec<f64>,
    pub(crate) claims: &'a [Claim],
    /// Number of the first claim among all findings.
    pub(crate) first_finding: usize,
    /// What predicts without and with what was found.
    pub(crate) nominal: &'a [f64],
    pub(crate) with_all: &'a [f64],
    pub(crate) errors: &'a [[Errors; 2]],
    pub(crate) deviations: &'a [[f64; QUANTITIES]],
    /// The nominal value of a claim's parameter.
    pub(crate) nominal_of: &'a dyn Fn(&Claim, &str) -> Option<f64>,
}
