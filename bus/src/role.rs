//! What every process of a run does first, and how its end is told.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use crate::bell::{Bell, Stage};
use crate::experiment::Experiment;
use crate::place::{Alive, Place};
use crate::services::Services;
use crate::shared::{Parent, await_stage};
use crate::transport::BusError;

/// A process inside its run.
#[derive(Debug)]
pub struct Joined {
    /// The experiment.
    pub experiment: Experiment,
    /// The bell page.
    pub bell: Rc<Bell>,
    /// The launcher.
    pub parent: Parent,
    /// Where the run's files are.
    pub place: Place,
    _alive: Alive,
}

/// How a process came to its end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ended {
    /// The experiment was over.
    Done,
    /// The run was stopped before.
    Stopped,
    /// Something failed.
    Failed(String),
}

impl From<Result<(), BusError>> for Ended {
    fn from(result: Result<(), BusError>) -> Self {
        match result {
            Ok(()) => Self::Done,
            Err(BusError::Stopped) => Self::Stopped,
            Err(error) => Self::Failed(error.to_string()),
        }
    }
}

impl Joined {
    /// Joins the run in `folder`.
    ///
    /// # Errors
    /// When there is no such run.
    pub fn new(folder: &Path) -> Result<Self, BusError> {
        let parent = Parent::now();
        let failed = |what: PathBuf| {
            move |error: std::io::Error| BusError::Failed {
                what: what.display().to_string(),
                reason: error.to_string(),
            }
        };
        let (place, alive) = Place::join(folder).map_err(failed(folder.to_owned()))?;
        let bytes = std::fs::read(place.experiment()).map_err(failed(place.experiment()))?;
        let experiment =
            postcard::from_bytes(&bytes).map_err(|e| BusError::failed("experiment", e))?;
        let bell = Rc::new(Bell::open(&place.bell()).map_err(failed(place.bell()))?);
        Ok(Self {
            experiment,
            bell,
            parent,
            place,
            _alive: alive,
        })
    }

    /// Waits until the plant has created the services and joins them as `name`.
    ///
    /// # Errors
    /// When the run ends before.
    pub fn services(&self, name: &str) -> Result<Services, BusError> {
        await_stage(&self.bell, Stage::Services, self.parent)?;
        Services::join(&self.place, &self.experiment, name)
    }
}
