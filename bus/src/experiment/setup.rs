//! Complete description of a run: settings, robots, and the content of the files that they name.

use serde::{Deserialize, Serialize};

use super::settings::Settings;
use crate::message::robot_name;
use crate::robot::RobotModel;

/// An experiment ready to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// The settings.
    pub settings: Settings,
    /// The robots, from the front.
    pub robots: Vec<RobotSetup>,
    /// Half of each round trip of `links.trace` (ns), `None` for a lost one; empty without a trace.
    pub half_round_trips_ns: Vec<Option<i64>>,
}

/// One robot of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotSetup {
    /// Its name, `r1` at the front.
    pub name: String,
    /// The true model, which the plant simulates. The controller knows it without the effects.
    pub model: RobotModel,
    /// Initial pose of c: x (m), y (m), yaw (rad).
    pub pose: [f64; 3],
    /// Where what its wheels do is known from.
    pub wheels: WheelSource,
}

/// Where what the wheels of a robot do is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum WheelSource {
    /// Encoders of the simulated plant.
    #[default]
    Simulated,
    /// Wheel angles that a real robot sends.
    Angles,
    /// Wheel angles that a real robot sends beside its own odometry.
    AnglesAndOdometry,
    /// A real robot's odometry: the angles that its wheels would have by the model.
    Odometry,
}

impl WheelSource {
    /// Whether a real robot tells its own odometry.
    pub fn has_odometry(self) -> bool {
        matches!(self, Self::AnglesAndOdometry | Self::Odometry)
    }
}

impl Experiment {
    /// An experiment whose robots all have the same model and stand at their initial poses
    /// ([`Settings::start_pose`]), without a trace of round trips.
    pub fn new(settings: Settings, model: &RobotModel) -> Self {
        let robots = (0..settings.robots.count)
            .map(|index| RobotSetup {
                name: robot_name(index),
                model: model.clone(),
                pose: settings.start_pose(index),
                wheels: WheelSource::Simulated,
            })
            .collect();
        Self {
            settings,
            robots,
            half_round_trips_ns: Vec::new(),
        }
    }

    /// The longest delay of the trace of round trips (ns); 0 without a trace.
    pub fn longest_trace_ns(&self) -> i64 {
        let delays = self.half_round_trips_ns.iter().flatten();
        delays.copied().max().unwrap_or(0)
    }
}
