//! The program in its roles: what the launcher starts, named by the first argument.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, Parser};
use serde::Serialize;
use serde::de::DeserializeOwned;
use slipstream_agents::process as agent;
use slipstream_bus::message::robot_name;
use slipstream_bus::transport::BusError;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::trace;
use slipstream_sim::run::process as plant;

use crate::recorder;
use crate::tape::leave_tape;

/// A role and what it needs to know.
#[derive(Debug, Parser)]
#[command(
    name = "slipstream",
    about = "A process of a run; started by slipstream run"
)]
pub(crate) enum Role {
    /// The world.
    Plant(Membership),
    /// One robot's controller.
    Agent {
        #[command(flatten)]
        membership: Membership,
        /// Which robot, counted from 0.
        #[arg(long)]
        robot: u32,
        /// A predecessor died.
        #[arg(long)]
        rejoins: bool,
    },
    /// Writes everything down.
    Recorder {
        #[command(flatten)]
        membership: Membership,
        /// The file.
        #[arg(long)]
        out: PathBuf,
    },
}

#[derive(Debug, Clone, Args)]
pub(crate) struct Membership {
    /// The run's folder.
    #[arg(long)]
    run: PathBuf,
    /// Somebody records.
    #[arg(long)]
    recording: bool,
    /// The recording holds a trace.
    #[arg(long)]
    trace: bool,
}

/// The names of the roles.
const NAMES: [&str; 3] = ["plant", "agent", "recorder"];

/// Whether these arguments are those of a role.
pub fn is_role(arguments: &[OsString]) -> bool {
    arguments
        .get(1)
        .and_then(|name| name.to_str())
        .is_some_and(|name| NAMES.contains(&name))
}

/// Plays the role that the arguments name, to its end. Says whether it came to a report.
pub fn play(arguments: &[OsString]) -> bool {
    let role = match Role::try_parse_from(arguments) {
        Ok(role) => role,
        // Nobody but the launcher starts a role: says so and ends with exit code 2.
        Err(error) => error.exit(),
    };
    let membership = role.membership();
    let filter = match membership.trace.then(trace::filter).transpose() {
        Ok(filter) => filter,
        Err(problem) => {
            complain(&role, &format!("{}: {problem}", trace::VARIABLE));
            return false;
        }
    };
    let _tracing = filter.map(|filter| trace::begin(&role.name(), filter));
    let process = tracing::info_span!("process").entered();
    let played = role.play();
    drop(process);
    leave_tape(&membership.run, &role.name());
    match played {
        Ok(()) | Err(BusError::Stopped) => true,
        Err(error) => {
            complain(&role, &error.to_string());
            false
        }
    }
}

/// Where standard error is closed there is nobody to tell.
fn complain(role: &Role, problem: &str) {
    let _ = writeln!(std::io::stderr(), "slipstream {}: {problem}", role.name());
}

impl Role {
    fn play(&self) -> Result<(), BusError> {
        match self {
            Self::Plant(Membership { run, recording, .. }) => {
                report(run, &self.name(), &plant::run(run, *recording)?)
            }
            Self::Agent {
                membership: Membership { run, recording, .. },
                robot,
                rejoins,
            } => report(
                run,
                &self.name(),
                &agent::run(run, *robot, *rejoins, *recording)?,
            ),
            Self::Recorder {
                membership: Membership { run, .. },
                out,
            } => report(run, &self.name(), &recorder::run(run, out)?),
        }
    }

    fn membership(&self) -> &Membership {
        match self {
            Self::Plant(membership)
            | Self::Agent { membership, .. }
            | Self::Recorder { membership, .. } => membership,
        }
    }

    /// `plant`, `recorder`, or the robot's name.
    fn name(&self) -> String {
        match self {
            Self::Plant(_) => "plant".to_owned(),
            Self::Agent { robot, .. } => robot_name(*robot),
            Self::Recorder { .. } => "recorder".to_owned(),
        }
    }
}

fn report(folder: &Path, name: &str, outcome: &impl Serialize) -> Result<(), BusError> {
    let failed = |e: std::io::Error| BusError::failed("report", e);
    let bytes = postcard::to_allocvec(outcome).map_err(|e| BusError::failed("report", e))?;
    // Under its name only when it is whole.
    let making = folder.join(format!("report-{name}.making"));
    match std::fs::write(&making, bytes)
        .and_then(|()| std::fs::rename(&making, folder.join(format!("report-{name}"))))
    {
        // The launcher has cleaned up already: nobody wants the report.
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        result => result.map_err(failed),
    }
}

/// What a process had to say at its end, if it came to say it.
pub(crate) fn read_report<T: DeserializeOwned>(place: &RunDirectory, name: &str) -> Option<T> {
    let bytes = std::fs::read(place.folder().join(format!("report-{name}"))).ok()?;
    postcard::from_bytes(&bytes).ok()
}
