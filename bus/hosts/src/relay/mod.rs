//! Relay: the process on another host that takes the part of the plant and of the recorder.
//!
//! To the agents of its host it is what the plant is: it brings them encoders and collects their torques. It sends home
//! what they record, and in the end what they leave.

mod lockstep;
mod play;
mod wall;

use std::path::Path;

use serde::{Deserialize, Serialize};
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::presence::Parent;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::{Member, Stage};

use self::play::{Play, stopped_by_plant};
use crate::carrier::HostCarrier;
use crate::frame::LeftFile;

/// What the relay is started with.
pub struct Relay<'a> {
    /// The run directory of this host.
    pub folder: &'a Path,
    /// The launcher of this host.
    pub launcher: Parent,
    /// Number of the run that this host has joined.
    pub run: u64,
    /// The run is recorded.
    pub recording: bool,
    /// The files that the agents of these robots left, in the run directory.
    pub left: &'a dyn Fn(&[RobotIndex]) -> Vec<LeftFile>,
    /// Why the launcher stopped the agents of this host, if it did.
    pub failure: &'a dyn Fn() -> Option<String>,
}

/// How the relay ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RelayOutcome {
    /// How it ended.
    pub ended: ProcessStatus,
}

impl Relay<'_> {
    /// Takes the part of the plant until the run is over and all has been sent home.
    ///
    /// # Errors
    /// It cannot join the run of this host. Errors after that are in [`RelayOutcome::ended`].
    pub fn run(self, carrier: &mut dyn HostCarrier) -> Result<RelayOutcome, BusError> {
        let joined = JoinedRun::new(self.folder, Member::Plant, self.launcher)?;
        let services = Services::join(&joined.directory, &joined.experiment, "relay")?;
        let services = services.with_local(|robot| joined.wake_page().is_local(robot));
        let kept = services.create_all()?;
        joined.wake_page().advance(Stage::Services);
        let mut play = Play::new(&joined, &services, carrier, self.run)?;
        let ended = play
            .await_agents()
            .and_then(|()| {
                drop(kept);
                if services.lockstep() {
                    lockstep::rounds(&mut play)
                } else {
                    wall::pass_on(&mut play, &services, self.recording)
                }
            })
            .and_then(|stopped| {
                play.send_report(self.left, self.failure)?;
                stopped.map_or(Ok(()), |reason| Err(stopped_by_plant(reason)))
            });
        joined.wake_page().advance(Stage::Over);
        if let Err(error) = &ended {
            play.fail(error, self.failure);
        }
        Ok(RelayOutcome {
            ended: ended.into(),
        })
    }
}
