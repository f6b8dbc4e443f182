//! What is wrong with the recordings themselves. What would pose as physics is refused; what only
//! makes an answer poorer is said.

use serde::Serialize;
use slipstream_recording::{Finding as Fault, faults};

use crate::windows::{InputError, Request};

/// Faults that no effect of the catalogue has, and that any would be bent to: a diagnosis would name
/// a wrong physics.
const REFUSED: [&str; 7] = [
    "units",
    "wheels_swapped",
    "wheel_reversed",
    "wheels_reversed",
    "wheels_swapped_and_reversed",
    "opposite_signs",
    "no_overlap",
];

/// Something about a recording that makes the answer poorer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Warning {
    /// The recording.
    pub recording: String,
    /// The robot; null when it is about all.
    pub robot: Option<String>,
    /// A word for programs, such as `gaps`.
    pub id: String,
    /// What it is.
    pub statement: String,
    /// What to do about it.
    pub remedy: String,
}

/// Looks the recordings over.
///
/// # Errors
/// What cannot be diagnosed as it is.
pub(crate) fn warnings(request: &Request<'_>) -> Result<Vec<Warning>, InputError> {
    let mut warnings = Vec::new();
    for recording in request.recordings {
        for fault in faults(recording, request.model_of) {
            if REFUSED.contains(&&*fault.id) {
                return Err(refusal(&recording.name, fault));
            }
            warnings.push(Warning {
                recording: recording.name.clone(),
                robot: fault.robot,
                id: fault.id.into_owned(),
                statement: fault.statement,
                remedy: fault.remedy,
            });
        }
    }
    Ok(warnings)
}

fn refusal(recording: &str, fault: Fault) -> InputError {
    let place = match fault.robot {
        Some(robot) => format!("{recording}: {robot}"),
        None => recording.to_owned(),
    };
    InputError::new(place, fault.statement, fault.remedy)
}
