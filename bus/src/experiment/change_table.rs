//! A table of an experiment that says what begins at a time.

use serde::{Deserialize, Serialize};

use super::parameters::{ParameterValue, Parameters};
use crate::error::InputError;
use crate::range::invalid;

/// A table `[[changes]]`: `at_s` with `robot`, `effect` and its parameters, or with `link` and `delay_s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ChangeTable(Parameters);

impl From<Parameters> for ChangeTable {
    fn from(table: Parameters) -> Self {
        Self(table)
    }
}

impl ChangeTable {
    pub(super) fn entries(&self) -> &Parameters {
        &self.0
    }

    pub(super) fn number(&self, key: &str, remedy: &str) -> Result<f64, InputError> {
        match self.0.get(key) {
            Some(ParameterValue::Number(number)) => Ok(*number),
            Some(ParameterValue::Integer(whole)) => Ok(*whole as f64),
            Some(_) => invalid(key, "is no number", remedy),
            None => invalid(key, "is missing", remedy),
        }
    }

    pub(super) fn text(&self, key: &str, remedy: &str) -> Result<&str, InputError> {
        match self.0.get(key) {
            Some(ParameterValue::Text(text)) => Ok(text),
            Some(_) => invalid(key, "is no text", remedy),
            None => invalid(key, "is missing", remedy),
        }
    }
}
