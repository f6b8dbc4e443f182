//! What is wrong with the recordings themselves. What would pose as physics is refused; what only
//! makes an answer poorer is said.

use slipstream_recording::{Finding as Fault, faults};

use crate::answer::Warning;
use crate::diagnosis::Request;
use slipstream_bus::InputError;

/// Faults that no effect of the catalogue has, and that any would be bent to: a diagnosis would name
/// a wrong physics.
const REFUSED: [&str; 8] = [
    "units",
    "two_sources",
    "wheels_swapped",
    "wheel_reversed",
    "wheels_reversed",
    "wheels_swapped_and_reversed",
    "opposite_signs",
    "no_overlap",
];

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
