//! The experiment of a recording, to run it again: what was driven is simulated, what was simulated is simulated anew.

use std::collections::BTreeMap;
use std::path::Path;

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::{attached, robot_toml};

use super::key_tree::KeyTree;
use super::keys::File;
use super::request::Origin;

/// Keys that are not taken over: a run is simulated on the virtual clock, with the models that are attached.
const LEFT_OUT: [&str; 2] = ["clock", "robots.model"];
/// What to do without an experiment.
const REMEDY: &str = "give an MCAP file that slipstream run has written";

/// Models of robots, by name.
pub(super) type Models = BTreeMap<String, RobotModel>;

/// The keys of the experiment that is attached to a recording, and the models of its robots.
pub(super) fn read(path: &Path) -> Result<(KeyTree, Models), InputError> {
    let texts = attached(path).map_err(|error| match error {
        slipstream_recording::Error::Input(error) => error,
        other => InputError::file(path, other.to_string(), REMEDY),
    })?;
    let Some(text) = texts.get("experiment.toml") else {
        return Err(InputError::file(path, "has no experiment", REMEDY));
    };
    let file = File::parse(path, text)?;
    let platoon = KeyTree::built_in("platoon")?;
    let mut tree = platoon.ok_or_else(|| InputError::file(path, "has no base", REMEDY))?;
    for (key, value, line) in file.keys() {
        if !LEFT_OUT.contains(&key.as_str()) {
            tree.set(&key, value, &Origin::File(path.to_owned(), line))?;
        }
    }
    let mut models = Models::new();
    for (name, text) in &texts {
        let robot = ["simulated.", "nominal."].iter().find_map(|role| {
            let rest = name.strip_prefix(role)?;
            rest.strip_suffix(".toml")
        });
        if let Some(robot) = robot {
            let model = robot_toml::parse(text, &path.join(name))?;
            models.insert(robot.to_owned(), model);
        }
    }
    Ok((tree, models))
}
