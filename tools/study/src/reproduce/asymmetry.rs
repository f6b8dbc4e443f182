//! Which asymmetry between left and right explains the paper's lateral error. The paper says that a
//! robot turns when one wheel slips before the other; a symmetric robot does not turn. For each
//! asymmetry alone: the size that gives the measured lateral error without the torque limit, and the
//! lateral error at that size with the limit.

use slipstream_bus::{Experiment, RobotModel};
use slipstream_launch::{Request, resolve};

use super::printed::{FINALS, Finals};
use super::recorded_run::RecordedRun;
use super::row::Row;
use crate::StudyError;

const SOURCE: &str = "final positions, section 4";
/// Assumptions that change a run without the torque limit.
const ASSUMPTIONS_WITHOUT_LIMIT: [&str; 4] = ["profile", "gains", "motor", "friction"];
/// Assumptions that change a run with the torque limit.
const ASSUMPTIONS_WITH_LIMIT: [&str; 5] = ["profile", "gains", "motor", "friction", "limit"];

/// A way in which left and right may differ.
struct Asymmetry {
    name: &'static str,
    meaning: &'static str,
    /// The largest size tried.
    max_size: f64,
    /// The robot with an asymmetry of this size.
    robot: fn(RobotModel, f64) -> RobotModel,
}

/// Mass of the displaced load (kg): a battery pack for robots of this size.
const BATTERY_KG: f64 = 0.3;
/// Radius of a friction patch so large that its edge is nearly straight along the robots' path (m).
const HALF_PLANE_M: f64 = 1000.0;

const ASYMMETRIES: [Asymmetry; 4] = [
    Asymmetry {
        name: "asymmetry_motor_gain",
        meaning: "right motor stronger and left motor weaker by this share",
        max_size: 0.5,
        robot: |robot, size| {
            robot.with("motor_gain", &[("right", 1.0 + size), ("left", 1.0 - size)])
        },
    },
    Asymmetry {
        name: "asymmetry_battery_y_m",
        meaning: "0.3 kg of the load this far left of the middle (m)",
        max_size: 0.105,
        robot: |robot, size| {
            let place = [("mass_kg", BATTERY_KG), ("x_m", 0.0), ("y_m", size)];
            robot.with("payload", &place)
        },
    },
    Asymmetry {
        name: "asymmetry_floor_friction",
        meaning: "friction lower by this on the left half of the floor",
        max_size: 0.2,
        robot: |robot, size| {
            let half = [
                ("x_m", 2.5),
                ("y_m", HALF_PLANE_M),
                ("radius_m", HALF_PLANE_M),
                ("friction", 0.24 - size),
            ];
            robot.with("friction_patch", &half)
        },
    },
    Asymmetry {
        name: "asymmetry_wheel_radius",
        meaning: "right wheel larger by this share (no slip needed: odometry does not see it)",
        max_size: 0.05,
        robot: |robot, size| {
            robot.with(
                "wheel_radius",
                &[("right_scale", 1.0 + size), ("left_scale", 1.0)],
            )
        },
    },
];

/// Steps of the coarse search over the size of an asymmetry.
const COARSE_STEPS: u32 = 16;
/// Bisections of the step that contains the solution.
const BISECTIONS: u32 = 12;

/// Rows for each asymmetry: its size, and the lateral error with the limit; and the initial heading error
/// that would explain the lateral error without any slip.
pub(super) fn rows() -> Result<Vec<Row>, StudyError> {
    let [without, with] = FINALS.each_ref().map(Finals::mean_lateral_m);
    let mut rows = Vec::new();
    for asymmetry in &ASYMMETRIES {
        let size = smallest(asymmetry, without)?;
        let found = Row::found(asymmetry.name, SOURCE, size.unwrap_or(f64::NAN))
            .depending_on(&ASSUMPTIONS_WITHOUT_LIMIT);
        let Some(size) = size else {
            let largest_m = lateral_m(asymmetry, asymmetry.max_size, "none")?;
            rows.push(found.note(format!(
                "{}: no size up to {} gives the paper's mean lateral error of {without:.3} m without \
                 the limit; the largest gives {largest_m:.3} m",
                asymmetry.meaning, asymmetry.max_size
            )));
            continue;
        };
        let limited = lateral_m(asymmetry, size, "outer")?;
        rows.push(found.note(format!(
            "{}: gives the paper's mean lateral error of {without:.3} m without the limit",
            asymmetry.meaning
        )));
        let quantity = format!("lateral_error_with_limit_by_{}_m", asymmetry.name);
        let row =
            Row::printed(quantity, SOURCE, with, limited).depending_on(&ASSUMPTIONS_WITH_LIMIT);
        rows.push(row.note(
            "the same asymmetry with the limit. One that needs slip is made smaller by the limit, as \
             in the paper; one that does not is not",
        ));
    }
    rows.push(heading(with)?);
    Ok(rows)
}

/// An initial heading error, which odometry does not see and the limit does not change.
fn heading(lateral_m: f64) -> Result<Row, StudyError> {
    let run = RecordedRun::of_experiment("platoon", "outer", &[])?;
    let robots = run.reports.plant.robots.iter().zip(&run.experiment.robots);
    let distance_m: f64 = robots
        .map(|(end, start)| end.final_true[0] - start.pose[0])
        .sum::<f64>()
        / 3.0;
    let row = Row::found(
        "asymmetry_start_heading_rad",
        SOURCE,
        (lateral_m / distance_m).asin(),
    )
    .depending_on(&ASSUMPTIONS_WITH_LIMIT);
    Ok(row.note(format!(
        "a start turned by this gives the {lateral_m:.3} m that are left with the limit, and the same \
         without it: it cannot explain the difference between the two"
    )))
}

/// The smallest size whose mean lateral error without the limit reaches `target_m`; `None` if none does.
fn smallest(asymmetry: &Asymmetry, target_m: f64) -> Result<Option<f64>, StudyError> {
    let mut low = 0.0;
    for step in 1..=COARSE_STEPS {
        let mut high = asymmetry.max_size * f64::from(step) / f64::from(COARSE_STEPS);
        if lateral_m(asymmetry, high, "none")? < target_m {
            low = high;
            continue;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if lateral_m(asymmetry, middle, "none")? < target_m {
                low = middle;
            } else {
                high = middle;
            }
        }
        return Ok(Some(high));
    }
    Ok(None)
}

/// Mean final lateral distance of the robots from the straight line (m).
fn lateral_m(asymmetry: &Asymmetry, size: f64, torque_limit: &str) -> Result<f64, StudyError> {
    let request = Request {
        set: vec![("control.torque_limit".to_owned(), torque_limit.to_owned())],
        ..Request::default()
    };
    let mut experiment: Experiment = resolve(&request)?.experiment;
    for robot in &mut experiment.robots {
        robot.model = (asymmetry.robot)(robot.model.clone(), size);
    }
    Ok(RecordedRun::new(experiment)?.mean_lateral_m())
}
