//! The robot that a bag describes itself: a URDF in a topic `robot_description`.

use std::path::{Path, PathBuf};

use slipstream_bag::{Bag, Result};
use slipstream_bus::InputError;

use crate::foreign_bag::{
    InBag, TopicMap, WheelJoints, WheelNames, descriptions_in, draft_topics, read_foreign,
};
use crate::import::Spooled;
use crate::recording::Recording;
use crate::robot_file::{self, Described};

/// Reads a bag of another robot, with the model that it carries. `wheels` are those of the user's models.
///
/// # Errors
/// If it cannot be read, or does not fit its map.
pub(crate) fn read_with_model(
    bag: &dyn Bag,
    path: &Path,
    map: Option<&TopicMap>,
    wheels: &[WheelJoints],
) -> Result<Spooled> {
    let wheel_names = WheelNames {
        given: wheels,
        of: &|own| wheels_in(own, path),
    };
    let (mut spooled, described) = read_foreign(bag, path, map, &wheel_names)?;
    let description = &mut spooled.recording.description;
    spooled
        .on_model
        .extend(take_model(&described, path, description));
    Ok(spooled)
}

/// Takes the model of the robot that a bag describes. Returns what a person should know about it.
pub(crate) fn take_model(
    described: &[InBag],
    path: &Path,
    recording: &mut Recording,
) -> Vec<String> {
    match described {
        [] => Vec::new(),
        [only] => take_only_model(only, path, recording),
        several => {
            let names = names(several);
            vec![format!(
                "{names} describe different robots: no model is taken from them"
            )]
        }
    }
}

/// The text of a map of a bag's topics, to be completed by a person.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(crate) fn draft_with_model(
    bag: &dyn Bag,
    path: &Path,
    wheels: &[WheelJoints],
) -> Result<String> {
    let wheel_names = WheelNames {
        given: wheels,
        of: &|own| wheels_in(own, path),
    };
    draft_topics(bag, &wheel_names)
}

/// The wheels that a description names, if it can be read.
pub(crate) fn wheels_in(own: &InBag, path: &Path) -> Option<WheelJoints> {
    parse(own, path).ok().map(|own| own.wheel_joints)
}

/// The text that describes the robot in a bag (a URDF), and its place in it.
///
/// # Errors
/// If the bag cannot be read, has no description or several.
pub(crate) fn description_in(bag: &dyn Bag, path: &Path) -> Result<(PathBuf, String)> {
    let remedy = "give a URDF, the YAML of a controller or a robot.toml";
    match descriptions_in(bag)?.as_slice() {
        [only] => Ok((place(only, path), only.text.clone())),
        [] => {
            let problem = "is a bag without a robot_description";
            Err(InputError::file(path, problem, remedy).into())
        }
        several => {
            let problem = format!("describes different robots in {}", names(several));
            Err(InputError::file(path, problem, remedy).into())
        }
    }
}

fn names(described: &[InBag]) -> String {
    let names: Vec<&str> = described.iter().map(|own| own.topic.as_str()).collect();
    names.join(", ")
}

/// In errors, the topic is named as a file inside the bag.
fn place(own: &InBag, path: &Path) -> PathBuf {
    path.join(own.topic.trim_start_matches('/'))
}

fn parse(own: &InBag, path: &Path) -> std::result::Result<Described, InputError> {
    robot_file::parse(&own.text, &place(own, path))
}

/// Takes the model of a description, or says why not.
fn take_only_model(own: &InBag, path: &Path, recording: &mut Recording) -> Vec<String> {
    let topic = &own.topic;
    let model = parse(own, path).and_then(|described| Ok((described.model()?, described.notes)));
    match model {
        Ok((model, notes)) => {
            let body = &model.robot;
            let first = format!(
                "robot model from {topic} in the bag: wheel_radius_m = {}, half_track_m = {}",
                body.wheel_radius_m, body.half_track_m
            );
            let notes = notes.iter().map(|note| format!("{topic}: {note}"));
            let all = std::iter::once(first).chain(notes).collect();
            recording.model = Some(model);
            all
        }
        Err(error) => vec![format!(
            "no robot model from {topic} in the bag: it {}; `slipstream robot {} --out robot.toml` writes one to be completed",
            error.problem,
            path.display()
        )],
    }
}
