//! Robot models of the command line: `--robot FILE` for all robots, `--robot NAME=FILE` for one; several files of one robot
//! fill what the others lack.

use std::path::{Path, PathBuf};

use slipstream_bus::RobotModel;
use slipstream_recording::robot_file::{Described, Kind};
use slipstream_recording::{describe_robot, describe_robots};

use crate::exit::Error;
use crate::print::{note_line, prints};
use crate::subject::named_file;

/// Models by robot name. A model without a name is for every robot that has none of its own.
#[derive(Debug)]
pub(crate) struct Models(Vec<Given>);

/// What was given for a robot, or for all.
#[derive(Debug)]
struct Given {
    name: Option<String>,
    model: RobotModel,
    described: Described,
}

impl Models {
    /// Reads the models of `[NAME=]FILE` arguments, and prints what was taken from files that are no robot.toml.
    pub(crate) fn read(arguments: &[String]) -> Result<Self, Error> {
        let files: Vec<(Option<String>, PathBuf)> =
            arguments.iter().map(|own| named_file(own)).collect();
        let mut models = Vec::new();
        for (name, described) in describe_robots(&files)? {
            let model = described.model()?;
            print_taken(&described, &model);
            models.push(Given {
                name,
                model,
                described,
            });
        }
        Ok(Self(models))
    }

    /// Reads the model of all robots from files that are about one.
    pub(crate) fn of_all(files: &[PathBuf]) -> Result<Option<RobotModel>, Error> {
        if files.is_empty() {
            return Ok(None);
        }
        let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        let described = describe_robot(&files)?;
        let model = described.model()?;
        print_taken(&described, &model);
        Ok(Some(model))
    }

    /// The model for `robot`, if one was given.
    pub(crate) fn of(&self, robot: &str) -> Option<RobotModel> {
        self.given(robot).map(|own| own.model.clone())
    }

    fn given(&self, robot: &str) -> Option<&Given> {
        let named = self.0.iter().find(|own| own.name.as_deref() == Some(robot));
        named.or_else(|| self.0.iter().find(|own| own.name.is_none()))
    }
}

/// Prints the lengths, and what was assumed: as a number, or with --verbose in words.
fn print_taken(described: &Described, model: &RobotModel) {
    let files = described
        .sources
        .iter()
        .map(|own| own.file.display().to_string());
    let files = files.collect::<Vec<_>>().join(" ");
    if described
        .sources
        .iter()
        .any(|own| own.kind != Kind::RobotToml)
    {
        let notes = match described.notes.len() {
            0 => String::new(),
            1 => format!("; 1 note: slipstream robot {files}"),
            count => format!("; {count} notes: slipstream robot {files}"),
        };
        let body = &model.robot;
        let (radius_m, half_track_m) = (body.wheel_radius_m, body.half_track_m);
        note_line!("{files}: wheel_radius_m = {radius_m}, half_track_m = {half_track_m}{notes}");
    }
    if prints().details {
        for note in &described.notes {
            note_line!("{files}: {note}");
        }
    }
}
