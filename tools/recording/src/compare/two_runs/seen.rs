//! What is read of a robot in one recording.

use slipstream_bus::RobotModel;

use super::places::{Place, places, smooth};
use super::rolled::rolled;
use crate::recording::Robot;

/// What is read of a robot.
pub(super) struct Seen {
    /// Poses of its c as they were measured.
    pub(super) places: Vec<Place>,
    /// The same without most of their noise.
    pub(super) smooth: Vec<Place>,
    /// Standard deviation of x and of y (m), if known.
    pub(super) noise_m: Option<f64>,
    /// Time (s) and distance that the wheels have rolled (m).
    pub(super) rolled: Vec<(f64, f64)>,
}

impl Seen {
    pub(super) fn of(robot: &Robot, model: Option<&RobotModel>) -> Self {
        let places = places(robot, model);
        Self {
            smooth: smooth(&places),
            places,
            noise_m: robot.noise.pose_m,
            rolled: rolled(robot, model),
        }
    }
}
