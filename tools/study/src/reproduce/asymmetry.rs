//! What it takes for the paper's lateral error. It says that slip at one wheel before the other
//! turns the robot; with everything alike nothing turns. Each row is one asymmetry by itself, as
//! large as it must be for the measured lateral error without the limit, and what it then does
//! with the limit.

use slipstream_bus::{Experiment, RobotModel};
use slipstream_launch::{Request, resolve};

use super::printed::FINALS;
use super::row::Row;
use super::trial::Trial;
use crate::StudyError;

const SOURCE: &str = "final positions, section 4";
/// The search runs the platoon without the limit; what it finds is tried with it.
const WITHOUT: [&str; 4] = ["profile", "gains", "motor", "friction"];
const ALL: [&str; 5] = ["profile", "gains", "motor", "friction", "limit"];

/// One way in which left and right may differ.
struct Asymmetry {
    name: &'static str,
    meaning: &'static str,
    /// The largest that is tried.
    most: f64,
    /// The robot with it, by its size.
    robot: fn(RobotModel, f64) -> RobotModel,
}

/// Mass whose place is sought (kg): a battery pack of the robots' size.
const BATTERY_KG: f64 = 0.3;
/// A disc so large that its edge is a straight line along the robots' way (m).
const HALF_PLANE_M: f64 = 1000.0;

const ASYMMETRIES: [Asymmetry; 4] = [
    Asymmetry {
        name: "asymmetry_motor_gain",
        meaning: "right motor stronger and left motor weaker by this share",
        most: 0.5,
        robot: |robot, size| {
            robot.with("motor_gain", &[("right", 1.0 + size), ("left", 1.0 - size)])
        },
    },
    Asymmetry {
        name: "asymmetry_battery_y_m",
        meaning: "0.3 kg of the load this far left of the middle (m)",
        most: 0.105,
        robot: |robot, size| {
            let place = [("mass_kg", BATTERY_KG), ("x_m", 0.0), ("y_m", size)];
            robot.with("payload", &place)
        },
    },
    Asymmetry {
        name: "asymmetry_floor_friction",
        meaning: "friction lower by this on the left half of the floor",
        most: 0.2,
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
        most: 0.05,
        robot: |robot, size| {
            robot.with(
                "wheel_radius",
                &[("right_scale", 1.0 + size), ("left_scale", 1.0)],
            )
        },
    },
];

/// Steps of the search over an asymmetry's sizes, and halvings of the one that holds the answer.
const STEPS: u32 = 16;
const HALVINGS: u32 = 12;

/// For each asymmetry how large it must be and what it does with the limit; and the heading error
/// that would do without any slip.
pub(super) fn rows() -> Result<Vec<Row>, StudyError> {
    let [without, with] = FINALS
        .each_ref()
        .map(super::printed::Finals::mean_lateral_m);
    let mut rows = Vec::new();
    for asymmetry in &ASYMMETRIES {
        let size = smallest(asymmetry, without)?;
        let found = Row::found(asymmetry.name, SOURCE, size.unwrap_or(f64::NAN)).on(&WITHOUT);
        let Some(size) = size else {
            let most = lateral_m(asymmetry, asymmetry.most, "none")?;
            rows.push(found.note(format!(
                "{}: no size up to {} gives the paper's mean lateral error of {without:.3} m without \
                 the limit; the largest gives {most:.3} m",
                asymmetry.meaning, asymmetry.most
            )));
            continue;
        };
        let limited = lateral_m(asymmetry, size, "outer")?;
        rows.push(found.note(format!(
            "{}: gives the paper's mean lateral error of {without:.3} m without the limit",
            asymmetry.meaning
        )));
        let quantity = format!("lateral_error_with_limit_by_{}_m", asymmetry.name);
        let row = Row::printed(quantity, SOURCE, with, limited).on(&ALL);
        rows.push(row.note(
            "the same asymmetry with the limit. One that needs slip is made smaller by the limit, as \
             in the paper; one that does not is not",
        ));
    }
    rows.push(heading(with)?);
    Ok(rows)
}

/// A start that is not straight: what odometry cannot see, and the limit cannot change.
fn heading(lateral_m: f64) -> Result<Row, StudyError> {
    let ends = Trial::new("platoon", "outer")?;
    let ways = ends
        .reports
        .plant
        .robots
        .iter()
        .zip(&ends.experiment.robots);
    let way_m: f64 = ways
        .map(|(end, start)| end.final_true[0] - start.pose[0])
        .sum::<f64>()
        / 3.0;
    let row = Row::found(
        "asymmetry_start_heading_rad",
        SOURCE,
        (lateral_m / way_m).asin(),
    )
    .on(&ALL);
    Ok(row.note(format!(
        "a start turned by this gives the {lateral_m:.3} m that are left with the limit, and the same \
         without it: it cannot explain the difference between the two"
    )))
}

/// The smallest size with a mean lateral error without the limit of `target_m` (m).
fn smallest(asymmetry: &Asymmetry, target_m: f64) -> Result<Option<f64>, StudyError> {
    let mut low = 0.0;
    for step in 1..=STEPS {
        let mut high = asymmetry.most * f64::from(step) / f64::from(STEPS);
        if lateral_m(asymmetry, high, "none")? < target_m {
            low = high;
            continue;
        }
        for _ in 0..HALVINGS {
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

/// Mean lateral distance of the robots from the straight line at the end (m).
fn lateral_m(asymmetry: &Asymmetry, size: f64, torque_limit: &str) -> Result<f64, StudyError> {
    let request = Request {
        set: vec![("control.torque_limit".to_owned(), torque_limit.to_owned())],
        ..Request::default()
    };
    let mut experiment: Experiment = resolve(&request)?.experiment;
    for robot in &mut experiment.robots {
        robot.model = (asymmetry.robot)(robot.model.clone(), size);
    }
    Ok(Trial::run(experiment)?.mean_lateral_m())
}
