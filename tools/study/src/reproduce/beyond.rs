//! Beyond the paper (its future work): turning trajectories, a floor whose friction changes, and a
//! controller that knows the dynamics and the traction forces, each under every torque limit.

use serde::Serialize;
use slipstream_launch::{Request, resolve};

use super::trial::Trial;
use crate::StudyError;

/// One experiment under one torque limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beyond {
    /// A built-in experiment; `changing_floor` is the platoon over a disc of lower friction.
    pub experiment: &'static str,
    /// `control.law`.
    pub law: &'static str,
    /// `control.torque_limit`.
    pub torque_limit: &'static str,
    /// How long contacts slid: all robots, both wheels together (s).
    pub slip_time_s: f64,
    /// The largest true spacing error (m).
    pub max_spacing_error_m: f64,
    /// Distance between odometry and truth at the end, mean of all robots (m).
    pub mean_final_gap_m: f64,
    /// When the front robot's speed first reached 0.6 m/s (s): what caution costs.
    pub brisk_at_s: Option<f64>,
}

const EXPERIMENTS: [&str; 5] = [
    "platoon",
    "circle",
    "figure_eight",
    "lane_change",
    CHANGING_FLOOR,
];
const PAPER: &str = "paper";
const COMPUTED: &str = "computed_torque";
/// Laws with their limits.
const CONTROLS: [(&str, &str); 7] = [
    (PAPER, "none"),
    (PAPER, "inner"),
    (PAPER, "outer"),
    (PAPER, "adaptive"),
    (COMPUTED, "none"),
    (COMPUTED, "inner"),
    (COMPUTED, "adaptive"),
];
const CHANGING_FLOOR: &str = "changing_floor";
/// The disc lies where the platoon accelerates and brakes: its centre (m), radius (m), friction.
const DISC: [(&str, f64); 4] = [
    ("x_m", 2.5),
    ("y_m", 0.0),
    ("radius_m", 1.5),
    ("friction", 0.1),
];
/// All profiles here pass it (m/s).
const BRISK_M_S: f64 = 0.6;

/// Runs every experiment under every law and limit.
pub(super) fn table() -> Result<Vec<Beyond>, StudyError> {
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
) -> Result<Beyond, StudyError> {
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
            robot.model = robot.model.clone().with("friction_patch", &DISC);
        }
    }
    let trial = Trial::run(experiment)?;
    let robots = trial.robots();
    let gap_m = |robot| {
        trial
            .final_gap_m(robot, 0)
            .hypot(trial.final_gap_m(robot, 1))
    };
    let brisk = trial.states(0).find(|state| state.velocity[0] >= BRISK_M_S);
    Ok(Beyond {
        experiment: name,
        law,
        torque_limit,
        slip_time_s: trial.slip_time_s(),
        max_spacing_error_m: trial.max_spacing_error_m(),
        mean_final_gap_m: (0..robots).map(gap_m).sum::<f64>() / f64::from(robots),
        brisk_at_s: brisk.map(|state| slipstream_bus::time::s_from_ns(state.t_ns)),
    })
}
