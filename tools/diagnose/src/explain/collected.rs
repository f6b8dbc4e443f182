//! What is added to the answer while machine after machine is diagnosed.

use slipstream_bus::RobotModel;

use super::links::Course;
use crate::answer::Answer;
use crate::judge::Predictions;

/// What is added while machine after machine is diagnosed.
#[derive(Default)]
pub(crate) struct Collected {
    pub(crate) answer: Answer,
    pub(crate) improved: Vec<(String, RobotModel)>,
    pub(crate) courses: Vec<Course>,
    pub(crate) predictions: Vec<Predictions>,
}
