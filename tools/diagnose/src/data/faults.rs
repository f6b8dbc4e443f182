//! What is wrong with the recordings themselves. What would pose as physics is refused; what only
//! makes an answer poorer is said.

use std::borrow::Cow;

use slipstream_bus::RobotModel;
use slipstream_recording::{Finding as Fault, Recording, Severity, faults};

use crate::answer::Warning;
use crate::request::Request;
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

/// Faults that are refused where they are errors: what the wheels did is then not known.
const REFUSED_ERRORS: [&str; 5] = [
    "position_never_changes",
    "counts_per_row",
    "speeds_as_angles",
    "wraps_unclear",
    "wheel_never_changes",
];

fn is_refused(fault: &Fault) -> bool {
    let id = &&*fault.id;
    let is_error = fault.severity == Severity::Error;
    REFUSED.contains(id) || (is_error && REFUSED_ERRORS.contains(id))
}

/// The recordings as they are read: counters run on, rows that say nothing are left out. And what was done.
pub(crate) fn mended<'a>(
    recordings: &'a [Recording],
    model_of: &dyn Fn(&str) -> Option<RobotModel>,
) -> (Cow<'a, [Recording]>, Vec<Warning>) {
    let (mut all, mut warnings) = (Vec::new(), Vec::new());
    for recording in recordings {
        let (mended, found) = slipstream_recording::mended(recording, model_of);
        warnings.extend(
            found
                .into_iter()
                .map(|fault| warning(&recording.name, fault)),
        );
        all.push(mended);
    }
    if all.iter().all(|mended| matches!(mended, Cow::Borrowed(_))) {
        return (Cow::Borrowed(recordings), warnings);
    }
    let all = all.into_iter().map(Cow::into_owned).collect();
    (Cow::Owned(all), warnings)
}

/// Looks the recordings over.
///
/// # Errors
/// What cannot be diagnosed as it is.
pub(crate) fn warnings(request: &Request<'_>) -> Result<Vec<Warning>, InputError> {
    let mut warnings = Vec::new();
    let all = faults(request.recordings, request.model_of);
    for (recording, faults) in request.recordings.iter().zip(all) {
        for fault in faults {
            if is_refused(&fault) {
                return Err(refusal(&recording.name, fault));
            }
            warnings.push(warning(&recording.name, fault));
        }
    }
    Ok(warnings)
}

fn warning(recording: &str, fault: Fault) -> Warning {
    Warning {
        recording: recording.to_owned(),
        robot: fault.robot,
        id: fault.id.into_owned(),
        statement: fault.statement,
        remedy: fault.remedy,
    }
}

fn refusal(recording: &str, fault: Fault) -> InputError {
    let place = match fault.robot {
        Some(robot) => format!("{recording}: {robot}"),
        None => recording.to_owned(),
    };
    InputError::new(place, fault.statement, fault.remedy)
}
