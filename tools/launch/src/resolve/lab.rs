//! What `robots.toml` says of an experiment: how many robots, their models, where they start, and their limits.

use std::path::PathBuf;

use slipstream_bus::experiment::{Clock, Drive, WheelSource};
use slipstream_bus::{Experiment, InputError};
use slipstream_robots::lab::{Lab, WheelTopic};
use toml::Value;

use super::key_tree::KeyTree;
use super::request::Origin;

/// Models of robots: of all (`None`), or of the named one.
type LabModels = Vec<(Option<String>, PathBuf)>;

/// Sets the keys that the lab decides. Arguments come after it, and may set them again.
pub(super) fn set_keys(lab: &Lab, tree: &mut KeyTree) -> Result<(), InputError> {
    let origin = Origin::Argument(format!("--real {}", lab.path.display()));
    let mut set = |key: &str, value: Value| tree.set(key, value, &origin);
    let count = i64::try_from(lab.robots.len()).unwrap_or(i64::MAX);
    set("robots.count", Value::Integer(count))?;
    match lab.drive() {
        Drive::Twist => {
            set("control.drive", Value::String("twist".to_owned()))?;
            set("control.torque_limit", Value::String("none".to_owned()))?;
        }
        Drive::Torque => set("control.drive", Value::String("torque".to_owned()))?,
    }
    let limits = lab.limits();
    for (key, limit) in [
        ("speed_m_s", limits.speed_m_s),
        ("yaw_rate_rad_s", limits.yaw_rate_rad_s),
        ("acceleration_m_s2", limits.acceleration_m_s2),
        ("yaw_acceleration_rad_s2", limits.yaw_acceleration_rad_s2),
    ] {
        set(&format!("control.limits.{key}"), Value::Float(limit))?;
    }
    if lab.robots.iter().any(|robot| robot.start.is_some()) {
        let start = |(index, _)| {
            let pose = lab.start_pose(index);
            Value::Array(pose.map(Value::Float).to_vec())
        };
        let starts = (0..).zip(&lab.robots).map(start).collect();
        set("robots.start", Value::Array(starts))?;
    }
    Ok(())
}

/// The models of the lab's robots, but for those that are given by arguments.
pub(super) fn models(lab: &Lab, given: &LabModels) -> LabModels {
    let is_given = |name: &str| {
        let own = |other: &Option<String>| other.as_deref().is_none_or(|other| other == name);
        given.iter().any(|(other, _)| own(other))
    };
    let own = lab.robots.iter().filter(|robot| !is_given(&robot.name));
    let own = own.map(|robot| (Some(robot.name.clone()), robot.model.clone()));
    given.iter().cloned().chain(own).collect()
}

/// Checks that real robots can drive the experiment, and says where what their wheels do is known from.
pub(super) fn apply(lab: &mut Lab, experiment: &mut Experiment) -> Result<(), InputError> {
    let settings = &experiment.settings;
    let place = format!("--real {}", lab.path.display());
    let refuse = |problem: String, remedy: &str| Err(InputError::new(&place, problem, remedy));
    if settings.clock != Clock::Wall {
        return refuse("drives on the wall clock".to_owned(), "add --clock wall");
    }
    if settings.control.drive != lab.drive() {
        let (problem, remedy) = match lab.drive() {
            Drive::Twist => (
                "has robots that take twists",
                "leave control.drive = \"twist\"",
            ),
            Drive::Torque => (
                "has robots that take torques",
                "leave control.drive = \"torque\"",
            ),
        };
        return refuse(problem.to_owned(), remedy);
    }
    if !settings.changes.is_empty() {
        let problem = "is no simulation, which alone can have [[changes]]".to_owned();
        return refuse(problem, "leave them out of the experiment");
    }
    let count = settings.robots.count as usize;
    if count > lab.robots.len() {
        let problem = format!("has {} robots, and {count} are to drive", lab.robots.len());
        return refuse(problem, "give fewer --robots, or describe the others");
    }
    lab.robots.truncate(count);
    let limits = settings.control.limits;
    let allowed = lab.limits();
    if limits.both(&allowed) != limits {
        let problem = "has limits below control.limits".to_owned();
        return refuse(
            problem,
            "give control.limits within them, or leave control.limits out",
        );
    }
    for (setup, robot) in experiment.robots.iter_mut().zip(&lab.robots) {
        setup.wheels = match robot.wheels {
            WheelTopic::Joints { .. } if robot.odometry.is_some() => WheelSource::AnglesAndOdometry,
            WheelTopic::Joints { .. } => WheelSource::Angles,
            WheelTopic::Odometry { .. } => WheelSource::Odometry,
        };
    }
    Ok(())
}
