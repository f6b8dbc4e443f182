//! What is asked of a diagnosis.

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::Recording;
use slipstream_recording::recording::Robot as Recorded;

/// What is asked.
pub struct Request<'a> {
    /// Recordings of the same machines, fitted together.
    pub recordings: &'a [Recording],
    /// Recordings of the same machines from before: what changed since is found. None, and what the model
    /// leaves out is found.
    pub against: &'a [Recording],
    /// The nominal model of each robot; without one, that of the recording.
    pub model_of: &'a dyn Fn(&str) -> Option<RobotModel>,
    /// Effects that are not to be tried.
    pub excluded: &'a [String],
    /// Intervals (s) excluded from the analysis.
    pub excluded_s: &'a [[f64; 2]],
    /// Hears what is being done.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

/// Runs of one machine.
pub(crate) type Runs<'a> = [(&'a Recording, &'a Recorded)];

/// The nominal model of a robot.
pub(crate) fn model_of(
    request: &Request<'_>,
    (recording, robot): (&Recording, &Recorded),
) -> Result<RobotModel, InputError> {
    (request.model_of)(&robot.name)
        .or_else(|| recording.model.clone())
        .ok_or_else(|| {
            InputError::new(
                &robot.name,
                "has no model",
                "give one with --robot robot.toml",
            )
        })
}
