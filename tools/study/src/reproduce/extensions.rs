//! Beyond the paper (its future work): turns, a floor whose friction changes, and a controller that
//! knows the dynamics and the traction forces, each under every torque limit.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipstream_bus::time::s_from_ns;
use slipstream_launch::{Request, resolve};

use super::recorded_run::RecordedRun;
use crate::StudyError;

/// One experiment under one control law and torque limit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Extension {
    /// A built-in experiment; `changing_floor` is the platoon over a disc of lower friction.
    pub experiment: Cow<'static, str>,
    /// `control.law`.
    pub law: Cow<'static, str>,
    /// `control.torque_limit`.
    pub torque_limit: Cow<'static, str>,
    /// Slip time: how long contacts slid, summed over all robots and both wheels (s).
    pub slip_time_s: f64,
    /// The largest true spacing error (m).
    pub max_spacing_error_m: f64,
    /// Final distance between odometry and truth, mean over all robots (m).
    pub mean_final_gap_m: f64,
    /// When the front robot first reached 0.6 m/s (s): what a cautious limit costs.
    pub brisk_at_s: Option<f64>,
}

/// Experiments, as in [`Extension::experiment`].
const EXPERIMENTS: [&str; 5] = [
    "platoon",
    "circle",
    "figure_eight",
    "lane_change",
    CHANGING_FLOOR,
];
/// The paper's control law.
const PAPER: &str = "paper";
/// Computed torque.
const COMPUTED: &str = "computed_torque";
/// Every control law with each of its torque limits.
const CONTROLS: [(&str, &str); 7] = [
    (PAPER, "none"),
    (PAPER, "inner"),
    (PAPER, "outer"),
    (PAPER, "adaptive"),
    (COMPUTED, "none"),
    (COMPUTED, "inner"),
    (COMPUTED, "adaptive"),
];
/// The platoon over a disc of lower friction.
const CHANGING_FLOOR: &str = "changing_floor";
/// The disc of lower friction; it lies where the platoon accelerates and brakes.
const FRICTION_PATCH: [(&str, f64); 4] = [
    ("x_m", 2.5),
    ("y_m", 0.0),
    ("radius_m", 1.5),
    ("friction", 0.1),
];
/// Speed of [`Extension::brisk_at_s`] (m/s); all velocity profiles exceed it.
const BRISK_M_S: f64 = 0.6;

/// Runs every experiment under every control law and torque limit.
pub(super) fn extensions() -> Result<Vec<Extension>, StudyError> {
    let mut table = Vec::new();
    for experiment in EXPERIMENTS {
        for (law, torque_limit) in CONTROLS {
            table.push(run(experiment, law, torque_limit)?);
        }
    }
    Ok(table)
}

fn run(
    name: &'static str,
    law: &'static str,
    torque_limit: &'static str,
) -> Result<Extension, StudyError> {
    let changing = name == CHANGING_FLOOR;
    let request = Request {
        experiment: (!changing).then(|| name.to_owned()),
        set: [("control.law", law), ("control.torque_limit", torque_limit)]
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .to_vec(),
        ..Request::default()
    };
    let mut experiment = resolve(&request)?.experiment;
    if changing {
        for robot in &mut experiment.robots {
            robot.model = robot.model.clone().with("friction_patch", &FRICTION_PATCH);
        }
    }
    let run = RecordedRun::new(experiment)?;
    let robots = run.robots();
    let gap_m = |robot| run.final_gap_m(robot, 0).hypot(run.final_gap_m(robot, 1));
    let brisk = run.states(0).find(|state| state.velocity[0] >= BRISK_M_S);
    Ok(Extension {
        experiment: name.into(),
        law: law.into(),
        torque_limit: torque_limit.into(),
        slip_time_s: run.slip_time_s(),
        max_spacing_error_m: run.max_spacing_error_m(),
        mean_final_gap_m: (0..robots).map(gap_m).sum::<f64>() / f64::from(robots),
        brisk_at_s: brisk.map(|state| s_from_ns(state.t_ns)),
    })
}
