//! What is asked of a machine, and what is found.

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;
use slipstream_recording::recording::Robot;

use crate::answer::{Budget, Detectable, Figures, HeldOut, Outliers, ProcessNoise, Warning};
use crate::explain::claim::Claim;
use crate::explain::links::Course;
use crate::judge::{Predictions, Score};

/// What is asked of a machine.
pub(crate) struct Task<'a> {
    pub(crate) runs: &'a [(&'a Recording, &'a Robot)],
    pub(crate) model: &'a RobotModel,
    pub(crate) excluded: &'a [String],
    pub(crate) excluded_s: &'a [[f64; 2]],
    pub(crate) progress: &'a dyn Fn(&str),
    /// Number of the first finding, if figures are asked for.
    pub(crate) illustrate: Option<usize>,
    /// What it is compared with; `model` is then that of before.
    pub(crate) before: Option<Earlier<'a>>,
}

/// Runs from before, and what was learnt of them.
#[derive(Clone, Copy)]
pub(crate) struct Earlier<'a> {
    pub(crate) runs: &'a [(&'a Recording, &'a Robot)],
    pub(crate) learnt: &'a Learnt,
}

/// What runs from before say of a machine.
pub(crate) struct Learnt {
    /// The model with everything that it lacked.
    pub(crate) model: RobotModel,
    pub(crate) claims: Vec<Claim>,
    /// Deviations of scale and track among the runs, where they differ.
    pub(crate) spread: [Option<f64>; 2],
    /// Scale and track of each run beside those of the model (logarithms).
    pub(crate) offsets: Vec<[f64; 2]>,
    /// What the filters read of the machine as it was fitted, but for laws.
    pub(crate) at: Vec<f64>,
    /// The same of its drive, with its noise.
    pub(crate) drive: Option<Vec<f64>>,
    /// What is left of its own predictions with that model.
    pub(crate) errors: Score,
}

/// What was found on one machine.
pub(crate) struct Found {
    pub(crate) claims: Vec<Claim>,
    pub(crate) held_out: HeldOut,
    pub(crate) predictions: Predictions,
    pub(crate) detectable: Vec<Detectable>,
    pub(crate) budget: Vec<Budget>,
    pub(crate) outliers: Vec<Outliers>,
    pub(crate) process_noise: Vec<ProcessNoise>,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) improved: RobotModel,
    /// Begin and end of each run (s).
    pub(crate) spans_s: Vec<[f64; 2]>,
    /// What a report shows, where it is asked for.
    pub(crate) figures: Option<Figures>,
    /// Where each run went, as the filter has it.
    pub(crate) courses: Vec<Course>,
    /// Number of each run's robot among those given.
    pub(crate) robots: Vec<usize>,
}
