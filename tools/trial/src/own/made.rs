//! The copies of a recording, on disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use slipstream_bus::{InputError, RobotModel};
use slipstream_recording::{Recording, mended, robot_toml, write_folder};
use slipstream_sim::effects::find;

use super::change::Change;
use super::menu::changes;
use super::null::{Null, half};
use crate::TrialError;
use crate::label::{ConcealedEffect, DiagnosisVerdict, Label, ParameterValue};

/// One copy, and what it is compared with.
#[derive(Debug, Clone)]
pub struct OwnCase {
    /// Its name.
    pub name: String,
    /// What was done: `whole`, `halves` (with a change), or the kind of a null.
    pub kind: String,
    /// Folders of the copy and of what it is compared with.
    pub folders: [PathBuf; 2],
    /// The change that was put into it; none into a null.
    pub change: Option<Change>,
    /// The truth about it.
    pub label: Label,
}

/// All copies.
#[derive(Debug)]
pub struct OwnTrial {
    /// The nominal model.
    pub model: PathBuf,
    /// The copies.
    pub cases: Vec<OwnCase>,
}

/// Writes copies of a recording into a folder. Changes are put into the robot, or into all runs of one
/// machine; of several robots into the first.
///
/// # Errors
/// A recording without a robot, or a folder that cannot be written.
pub fn make(
    recording: &Recording,
    model: &RobotModel,
    folder: &Path,
) -> Result<OwnTrial, TrialError> {
    let Some(first) = recording.robots.first() else {
        let remedy = "give one with wheels or commands, and poses or a gyro";
        return Err(InputError::new(&recording.name, "holds no robot", remedy).into());
    };
    // a change must meet what a diagnosis reads: a counter that wraps is not stretched
    let (recording, _) = mended(recording, &|_| Some(model.clone()));
    let own = alone(&recording);
    let model_file = folder.join("robot.toml");
    std::fs::write(&model_file, robot_toml::to_text(model))
        .map_err(TrialError::system(model_file.display()))?;
    let mut maker = Maker {
        folder,
        robot: first.name.clone(),
        cases: Vec::new(),
    };
    let whole = maker.write("original", &own)?;
    for null in Null::ALL {
        let mut copy = own.clone();
        copy.robots.iter_mut().for_each(|robot| null.apply(robot));
        let kind = format!("null, {}", null.name());
        maker.add(&kind, &copy, &whole, None)?;
    }
    let list = changes(first, model);
    for change in &list {
        maker.add(
            "whole",
            &changed(&own, model, change),
            &whole,
            Some(*change),
        )?;
    }
    let halves = [half(&own, false), half(&own, true)];
    let folders = [
        maker.write("first-half", &halves[0])?,
        maker.write("second-half", &halves[1])?,
    ];
    maker.add("null, halves", &halves[1], &folders[0], None)?;
    maker.add("null, halves", &halves[0], &folders[1], None)?;
    for change in largest(&list) {
        let copy = changed(&halves[1], model, change);
        maker.add("halves", &copy, &folders[0], Some(*change))?;
    }
    Ok(OwnTrial {
        model: model_file,
        cases: maker.cases,
    })
}

/// The recording with its runs of one machine, or with its first robot alone.
pub fn alone(recording: &Recording) -> Recording {
    let mut own = recording.clone();
    own.model = None;
    if !own.same_robot {
        own.robots.truncate(1);
        own.links = None;
    }
    own
}

fn changed(recording: &Recording, model: &RobotModel, change: &Change) -> Recording {
    let mut copy = recording.clone();
    copy.robots
        .iter_mut()
        .for_each(|robot| change.apply(robot, model));
    copy
}

/// Of each kind of change the largest.
fn largest(all: &[Change]) -> impl Iterator<Item = &Change> {
    all.iter().skip(2).step_by(3)
}

struct Maker<'a> {
    folder: &'a Path,
    robot: String,
    cases: Vec<OwnCase>,
}

impl Maker<'_> {
    fn write(&self, name: &str, recording: &Recording) -> Result<PathBuf, TrialError> {
        let folder = self.folder.join(name);
        let named = Recording {
            name: name.to_owned(),
            ..recording.clone()
        };
        write_folder(&named, &folder).map_err(TrialError::from)?;
        Ok(folder)
    }

    fn add(
        &mut self,
        kind: &str,
        copy: &Recording,
        before: &Path,
        change: Option<Change>,
    ) -> Result<(), TrialError> {
        let name = format!("copy-{:02}", self.cases.len() + 1);
        let folder = self.write(&name, copy)?;
        let label = Label {
            verdict: if change.is_some() {
                DiagnosisVerdict::Explained
            } else {
                DiagnosisVerdict::Match
            },
            robot_toml: "robot.toml".to_owned(),
            kind: kind.to_owned(),
            notes: BTreeMap::new(),
            without: Vec::new(),
            nuisances: Vec::new(),
            allowed: Vec::new(),
            effects: change
                .iter()
                .map(|change| self.concealed(change, copy))
                .collect(),
            unknown: None,
        };
        self.cases.push(OwnCase {
            name,
            kind: kind.to_owned(),
            folders: [folder, before.to_owned()],
            change,
            label,
        });
        Ok(())
    }

    fn concealed(&self, change: &Change, copy: &Recording) -> ConcealedEffect {
        let parameters = change.parameters().into_iter();
        let look_alikes = copy.robots.first().map(|robot| change.look_alikes(robot));
        ConcealedEffect {
            effect: change.effect().to_owned(),
            robot: self.robot.clone(),
            parameters: parameters
                .map(|(name, value)| (name.to_owned(), ParameterValue::Number(value)))
                .collect(),
            channels: find(change.effect())
                .iter()
                .flat_map(|info| info.channels)
                .map(|own| own.name().to_owned())
                .collect(),
            confusions: look_alikes.unwrap_or_default(),
            intervals_s: Vec::new(),
            expected_gain: None,
            deviations: BTreeMap::new(),
            runs: Vec::new(),
            tolerances: BTreeMap::new(),
        }
    }
}
