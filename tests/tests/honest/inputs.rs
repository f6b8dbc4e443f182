//! Recordings with their models, wherever they are.

use std::path::{Path, PathBuf};

use slipstream_bus::RobotModel;
use slipstream_recording::{Map, Recording, read_mapped, robot_file};

/// A recording to be diagnosed.
pub(crate) struct Input {
    pub(crate) name: String,
    pub(crate) recording: PathBuf,
    pub(crate) columns: Option<PathBuf>,
    pub(crate) robot: PathBuf,
}

/// What is there to be diagnosed in a folder of folders, by name: recordings with their `robot.toml`, and folders
/// that hold a bag or a table beside one.
pub(crate) fn inputs(folder: &Path) -> Vec<Input> {
    let mut all = Vec::new();
    for own in folders(folder) {
        let robot = own.join("robot.toml");
        if !robot.is_file() {
            continue;
        }
        let input = |recording: PathBuf, columns: Option<PathBuf>| Input {
            name: name(&recording, folder),
            recording,
            columns,
            robot: robot.clone(),
        };
        let columns = own.join("columns.toml");
        if own.join("recording.toml").is_file() {
            all.push(input(own, None));
        } else if own.join("log.csv").is_file() && columns.is_file() {
            all.push(input(own.join("log.csv"), Some(columns)));
        } else {
            let bags = folders(&own).into_iter();
            let bags = bags.filter(|bag| bag.join("metadata.yaml").is_file());
            all.extend(bags.map(|bag| input(bag, None)));
        }
    }
    all
}

fn name(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder)
        .unwrap_or(path)
        .display()
        .to_string()
}

fn folders(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut all: Vec<PathBuf> = paths.filter(|path| path.is_dir()).collect();
    all.sort();
    all
}

impl Input {
    /// Recording and model; the message of one that cannot be read.
    pub(crate) fn read(&self) -> Result<(Recording, RobotModel), String> {
        let map = Map::read(None, self.columns.as_deref()).map_err(|error| error.to_string())?;
        let import = read_mapped(&self.recording, &map).map_err(|error| error.to_string())?;
        let model = robot_file::read_model(&self.robot).map_err(|error| error.to_string())?;
        Ok((import.recording, model))
    }
}
