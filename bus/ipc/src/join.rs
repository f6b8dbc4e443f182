//! What every process of a run does first, and how its end is told.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use serde::{Deserialize, Serialize};

use crate::endpoints::{Parent, await_stage};
use crate::run_directory::{RunDirectory, RunLock};
use crate::services::Services;
use crate::wake_page::{Stage, WakePage};
use slipstream_bus::experiment::Experiment;
use slipstream_bus::transport::BusError;

/// A process inside its run.
#[derive(Debug)]
pub struct JoinedRun {
    /// The experiment.
    pub experiment: Experiment,
    /// The wake_page page.
    pub wake_page: Rc<WakePage>,
    /// The launcher.
    pub parent: Parent,
    /// Where the run's files are.
    pub place: RunDirectory,
    _alive: RunLock,
}

/// How a process came to its end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProcessStatus {
    /// The experiment was over.
    Done,
    /// The run was stopped before.
    Stopped,
    /// Something failed.
    Failed(String),
}

impl From<Result<(), BusError>> for ProcessStatus {
    fn from(result: Result<(), BusError>) -> Self {
        match result {
            Ok(()) => Self::Done,
            Err(BusError::Stopped) => Self::Stopped,
            Err(error) => Self::Failed(error.to_string()),
        }
    }
}

impl JoinedRun {
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
        let (place, alive) = RunDirectory::join(folder).map_err(failed(folder.to_owned()))?;
        let bytes = std::fs::read(place.experiment()).map_err(failed(place.experiment()))?;
        let experiment =
            postcard::from_bytes(&bytes).map_err(|e| BusError::failed("experiment", e))?;
        let wake_page =
            Rc::new(WakePage::open(&place.wake_page()).map_err(failed(place.wake_page()))?);
        Ok(Self {
            experiment,
            wake_page,
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
        await_stage(&self.wake_page, Stage::Services, self.parent)?;
        Services::join(&self.place, &self.experiment, name)
    }
}
