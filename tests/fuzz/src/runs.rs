//! Short runs of whatever was accepted: they end, and an error is one line.

use std::path::Path;

use slipstream_bus::{Experiment, Settings};
use slipstream_launch::in_process;
use slipstream_recording::robot_toml;

use crate::one_line::assert_one_line;

/// Duration of a run (s).
const SHORT_S: f64 = 0.02;
/// Larger runs take too long.
const MAX_ROBOTS: u32 = 4;

/// A `robot.toml`, and a run of the robot. A model without masses is refused by the controller.
pub(crate) fn robot_run(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    if let Ok(model) = robot_toml::parse(text, Path::new("robot.toml")) {
        short_run(Experiment::new(Settings::single(), &model));
    }
}

/// Runs the first moments of an experiment.
pub(crate) fn short_run(mut experiment: Experiment) {
    let settings = &mut experiment.settings;
    if settings.robots.count > MAX_ROBOTS {
        return;
    }
    settings.duration_s = settings.duration_s.min(SHORT_S);
    match in_process::run(&experiment, false) {
        Ok(reports) => {
            let poses = reports.plant.robots.iter().map(|robot| robot.final_true);
            assert!(poses.flatten().all(f64::is_finite));
        }
        Err(error) => assert_one_line(&error),
    }
}
