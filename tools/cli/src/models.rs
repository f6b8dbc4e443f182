//! Robot models of the command line: `--robot FILE` for all robots, `--robot NAME=FILE` for one; several files of one robot
//! fill what the others lack.

use std::path::PathBuf;

use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;
use slipstream_recording::robot_file::{Described, Kind};
use slipstream_recording::{WheelJoints, describe_robots};

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
        let files = arguments.iter().map(|own| named_file(own));
        Self::of_files(&files.collect::<Vec<_>>())
    }

    /// Reads the model of all robots from files that are about one; no models without files.
    pub(crate) fn of_one(files: &[PathBuf]) -> Result<Self, Error> {
        let all = files.iter().map(|file| (None, file.clone()));
        Self::of_files(&all.collect::<Vec<_>>())
    }

    /// No models.
    pub(crate) fn none() -> Self {
        Self(Vec::new())
    }

    fn of_files(files: &[(Option<String>, PathBuf)]) -> Result<Self, Error> {
        let mut models = Vec::new();
        for (name, described) in describe_robots(files)? {
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

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The wheels that the descriptions name, for the guess of a bag's topics.
    pub(crate) fn wheel_joints(&self) -> Vec<WheelJoints> {
        let joints = self.0.iter().map(|own| own.described.wheel_joints.clone());
        joints.collect()
    }

    /// Prints of which point the poses of robots count whose recording does not say it.
    pub(crate) fn note_poses(&self, robots: &[Robot]) {
        for robot in robots.iter().filter(|robot| robot.pose_point.is_none()) {
            let Some(given) = self.given(&robot.name).filter(|own| own.is_foreign()) else {
                continue;
            };
            if let Some(ahead_m) = given.model.robot.com_to_axle_m {
                let name = &robot.name;
                note_line!(
                    "{name}: poses count as those of the centre of mass, {ahead_m} m ahead of the axle, since recording.toml has \
                     no pose_point; if they are those of the axle's middle, write pose_point = \"axle\" under [robots.{name}]"
                );
            }
        }
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

impl Given {
    /// Whether it is not from a robot.toml alone.
    fn is_foreign(&self) -> bool {
        let mut sources = self.described.sources.iter();
        sources.any(|own| own.kind != Kind::RobotToml)
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
