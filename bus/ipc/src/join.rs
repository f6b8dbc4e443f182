//! Joining a run: the first steps of every process, and the status with which it ends.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use serde::{Deserialize, Serialize};
use slipstream_bus::experiment::Experiment;
use slipstream_bus::transport::BusError;

use crate::clock::{Monotonic, WallClock};
use crate::presence::{Parent, Presence};
use crate::run_directory::{RunDirectory, RunLock};
use crate::services::Services;
use crate::wake_page::{Member, Stage, WakePage};

/// A run that this process has joined.
#[derive(Debug)]
pub struct JoinedRun {
    /// The experiment.
    pub experiment: Experiment,
    /// The presence of this process.
    pub presence: Presence,
    /// The directory of the run.
    pub directory: RunDirectory,
    _lock: RunLock,
}

/// How a process ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProcessStatus {
    /// The experiment is complete.
    Done,
    /// The run was stopped before.
    Stopped,
    /// An operation failed, with the error text.
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
    /// Joins the run in `folder` as `member`: takes its lock, reads the experiment, opens the wake-up
    /// page.
    ///
    /// # Errors
    /// There is no live run in the folder, or one of its files cannot be read.
    pub fn new(folder: &Path, member: Member, parent: Parent) -> Result<Self, BusError> {
        let failed = |what: PathBuf| {
            move |error: std::io::Error| BusError::Failed {
                what: what.display().to_string(),
                reason: error.to_string(),
            }
        };
        let (directory, lock) = RunDirectory::join(folder).map_err(failed(folder.to_owned()))?;
        let path = directory.experiment();
        let bytes = std::fs::read(&path).map_err(failed(path))?;
        let experiment =
            postcard::from_bytes(&bytes).map_err(|e| BusError::failed("experiment", e))?;
        let path = directory.wake_page();
        let wake_page = Rc::new(WakePage::open(&path).map_err(failed(path))?);
        Ok(Self {
            experiment,
            presence: Presence::new(wake_page, member, parent),
            directory,
            _lock: lock,
        })
    }

    /// The wake-up page.
    pub fn wake_page(&self) -> &WakePage {
        self.presence.wake_page()
    }

    /// On the wall clock: the clock of the run, once its start is set.
    pub fn clock(&self) -> WallClock {
        WallClock::new(Monotonic::from_shared(self.wake_page().start_ns()))
    }

    /// Waits until the plant, or what stands for it on this host, has created the services, then opens them under the process name
    /// `name`.
    ///
    /// # Errors
    /// The run is stopped first, or the services cannot be opened.
    pub fn services(&self, name: &str) -> Result<Services, BusError> {
        self.presence.await_stage(Stage::Services)?;
        let services = Services::join(&self.directory, &self.experiment, name)?;
        Ok(services.with_local(|robot| self.wake_page().is_local(robot)))
    }
}
