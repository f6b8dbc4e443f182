//! Robot models of the command line: `--robot FILE` for all robots, `--robot NAME=FILE` for one.

use std::path::Path;

use slipstream_bus::RobotModel;
use slipstream_recording::WheelJoints;
use slipstream_recording::robot_file::{self, Kind};

use crate::exit::Error;
use crate::print::note_line;
use crate::subject::named_file;

/// Models by robot name. A model without a name is for every robot that has none of its own.
#[derive(Debug)]
pub(crate) struct Models(Vec<(Option<String>, RobotModel, WheelJoints)>);

impl Models {
    /// Reads the models of `[NAME=]FILE` arguments.
    pub(crate) fn read(arguments: &[String]) -> Result<Self, Error> {
        let mut models = Vec::new();
        for argument in arguments {
            let (name, file) = named_file(argument);
            let (model, wheels) = read_model(&file)?;
            models.push((name, model, wheels));
        }
        Ok(Self(models))
    }

    /// The model for `robot`, if one was given.
    pub(crate) fn of(&self, robot: &str) -> Option<RobotModel> {
        let named = self
            .0
            .iter()
            .find(|(name, ..)| name.as_deref() == Some(robot));
        let chosen = named.or_else(|| self.0.iter().find(|(name, ..)| name.is_none()));
        chosen.map(|(_, model, _)| model.clone())
    }

    /// The wheels that the descriptions name, for the guess of a bag's topics.
    pub(crate) fn wheel_joints(&self) -> Vec<WheelJoints> {
        self.0.iter().map(|(.., wheels)| wheels.clone()).collect()
    }
}

/// Reads a model from any description of a robot, with the joints of the wheels that it names, and prints what was assumed.
pub(crate) fn read_model(file: &Path) -> Result<(RobotModel, WheelJoints), Error> {
    let described = robot_file::read(file)?;
    let model = described.model()?;
    if described.kind != Kind::RobotToml {
        let body = &model.robot;
        note_line!(
            "{}: wheel_radius_m = {}, half_track_m = {}",
            file.display(),
            body.wheel_radius_m,
            body.half_track_m
        );
    }
    for note in &described.notes {
        note_line!("{}: {note}", file.display());
    }
    Ok((model, described.wheel_joints))
}
