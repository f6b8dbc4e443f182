//! The robots of an experiment: reads their models and checks them by building plant and controllers.

use std::path::PathBuf;

use slipstream_agents::{AgentContext, Geometry, Node, Paper};
use slipstream_bus::experiment::{Drive, Settings};
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::{Encoder, Experiment, InputError, RobotModel, RobotSetup};
use slipstream_recording::robot_file;

use super::key_tree::KeyTree;
use super::recorded::Models;

/// The robots, from the front, each with its model: as given, else that of the recording whose experiment it is.
///
/// # Errors
/// A model that cannot be read, or one for a robot that does not exist.
pub(super) fn robots(
    settings: &Settings,
    tree: &KeyTree,
    models: &[(Option<String>, PathBuf)],
    recorded: &Models,
) -> Result<Vec<RobotSetup>, InputError> {
    let described =
        slipstream_recording::describe_robots(models).map_err(|error| input("--robot", error))?;
    let of_all = described.iter().find(|(name, _)| name.is_none());
    let all = match (of_all, settings.robots.model.as_str()) {
        (Some((_, described)), _) => described.model()?,
        (None, "") => RobotModel::paper_with_slip(),
        (None, path) => {
            let path = tree.path("robots.model", path);
            let model = robot_file::read_model(&path);
            model.map_err(|error| input(&path.display().to_string(), error))?
        }
    };
    let mut robots = Experiment::new(settings.clone(), &all).robots;
    for robot in &mut robots {
        if let (Some(model), None) = (recorded.get(&robot.name), of_all) {
            robot.model = model.clone();
        }
    }
    for (name, described) in &described {
        let Some(name) = name else {
            continue;
        };
        let Some(robot) = robots.iter_mut().find(|robot| robot.name == *name) else {
            let last = robot_name(settings.robots.count - 1);
            let file = described
                .sources
                .first()
                .map(|own| own.file.display().to_string());
            return Err(InputError::new(
                format!("--robot {name}={}", file.unwrap_or_default()),
                format!("there is no robot {name}"),
                format!("give r1 to {last}"),
            ));
        };
        robot.model = described.model()?;
    }
    for robot in &mut robots {
        // Robots that are told twists say what their wheels have turned; that needs no encoder of a known resolution.
        let is_told_twists = settings.control.drive == Drive::Twist;
        if is_told_twists && robot.model.encoder.is_none() {
            robot.model.encoder = Some(Encoder::MICRORADIANS);
        }
    }
    Ok(robots)
}

/// Checks, before anything is started, that plant and controllers can be built.
///
/// # Errors
/// The first key of a robot model that prevents it.
pub(super) fn check(
    experiment: &Experiment,
    models: &[(Option<String>, PathBuf)],
) -> Result<(), InputError> {
    let located = |name: Option<&str>, error: InputError| {
        // The plant's errors have the form `robot: key`.
        let (named, key) = match error.place.split_once(": ") {
            Some((named, key)) => (Some(named), key),
            None => (name, error.place.as_str()),
        };
        let own = models
            .iter()
            .find(|(name, _)| name.is_some() && name.as_deref() == named);
        let all = models.iter().find(|(name, _)| name.is_none());
        let place = match (own.or(all), experiment.settings.robots.model.as_str()) {
            (Some((_, path)), _) => path.display().to_string(),
            (None, "") => named.unwrap_or("robot").to_owned(),
            (None, path) => path.to_owned(),
        };
        InputError::new(place, format!("{key} {}", error.problem), error.remedy)
    };
    slipstream_sim::run::world(experiment).map_err(|error| located(None, error))?;
    for (index, robot) in (0..).zip(&experiment.robots) {
        if experiment.settings.control.drive == Drive::Torque
            && Geometry::new(&robot.model).is_ok_and(|own| own.dynamics.is_none())
        {
            let problem = "lacks masses and lengths, and torques move nothing without them";
            let remedy =
                "give all of [robot], or tell its robots twists: --set control.drive=twist";
            let error = InputError::new("[robot]", problem, remedy);
            return Err(located(Some(&robot.name), error));
        }
        node(experiment, index).map_err(|error| located(Some(&robot.name), error))?;
    }
    Ok(())
}

/// Builds the agent of a robot. The controller of one with a program is built by that program.
fn node(experiment: &Experiment, index: RobotIndex) -> Result<(), InputError> {
    if experiment.settings.program(index).is_none() {
        return Node::new(experiment, index).map(|_| ());
    }
    let context = AgentContext::new(experiment, index)?;
    Node::with(experiment, index, Paper::new(&context)).map(|_| ())
}

/// An error about a description as one about what was given.
fn input(place: &str, error: slipstream_recording::Error) -> InputError {
    match error {
        slipstream_recording::Error::Input(error) => error,
        other => InputError::new(place, other.to_string(), "check the file"),
    }
}
