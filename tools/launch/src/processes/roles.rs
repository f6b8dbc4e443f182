//! Entry point of the processes of a run: the first argument names the role.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::PathBuf;

use clap::{Args, Parser};
use serde::Serialize;
use slipstream_agents::{BuiltIn, process as agent};
use slipstream_bus::transport::BusError;
use slipstream_hosts::address::{Address, Security};
use slipstream_hosts::hello::RemoteHost;
use slipstream_hosts::network;
use slipstream_hosts::relay::Relay;
use slipstream_hosts::stand_in::StandIn;
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::{part, report};
use slipstream_robots::lab::Lab;
use slipstream_robots::process as robots;
use slipstream_sim::run::process as plant;

use super::joined_host::HOST;
use super::state_transfer;
use crate::recorder;
use crate::role::Role;
use crate::run_files::read_keys;

/// Arguments of a process of a run.
#[derive(Debug, Parser)]
#[command(
    name = "slipstream",
    about = "A process of a run; started by slipstream run"
)]
enum RoleArguments {
    /// The physics of all robots.
    Plant(Membership),
    /// In place of the plant: what stands before real robots.
    Robots {
        #[command(flatten)]
        membership: Membership,
        /// The file robots.toml.
        #[arg(long)]
        lab: PathBuf,
    },
    /// The writer of the recording.
    Recorder {
        #[command(flatten)]
        membership: Membership,
        /// The file.
        #[arg(long)]
        out: PathBuf,
        /// Serve viewers at this address.
        #[arg(long)]
        serve: Option<String>,
        /// Begin once a viewer has subscribed.
        #[arg(long)]
        waits: bool,
    },
    /// What stands for the agents on other hosts.
    Hosts {
        #[command(flatten)]
        membership: Membership,
        #[command(flatten)]
        connection: Connection,
        /// The other hosts: NAME=ROBOT,…, counted from 0.
        #[arg(long)]
        host: Vec<RemoteHost>,
    },
    /// On another host: what stands for the plant and the recorder.
    Relay {
        #[command(flatten)]
        membership: Membership,
        #[command(flatten)]
        connection: Connection,
        /// The name of this host.
        #[arg(long)]
        name: String,
        /// Number of the run.
        #[arg(long)]
        number: u64,
    },
}

#[derive(Debug, Clone, Args)]
struct Connection {
    /// Where the plant's host listens.
    #[arg(long)]
    address: Address,
    /// Folder of the certificates.
    #[arg(long)]
    tls: Option<PathBuf>,
    /// No protection.
    #[arg(long)]
    insecure: bool,
}

impl Connection {
    fn security(&self) -> Security {
        Security::new(self.tls.clone(), self.insecure)
    }
}

#[derive(Debug, Clone, Args)]
struct Membership {
    /// The run directory.
    #[arg(long)]
    run: PathBuf,
    /// Process id of the launcher.
    #[arg(long)]
    launcher: u32,
    /// The run is recorded.
    #[arg(long)]
    recording: bool,
    /// The recording holds a trace.
    #[arg(long)]
    trace: bool,
}

impl Membership {
    fn as_part(&self) -> part::Membership {
        part::Membership {
            run: self.run.clone(),
            launcher: Parent::of_id(self.launcher),
            recording: self.recording,
            trace: self.trace,
        }
    }
}

/// Whether the arguments are those of a process of a run.
pub fn is_role(arguments: &[OsString]) -> bool {
    let roles = [
        Role::Plant,
        Role::Robots,
        Role::Agent(0),
        Role::Recorder,
        Role::StandIn(0),
        Role::Relay,
    ];
    arguments
        .get(1)
        .and_then(|name| name.to_str())
        .is_some_and(|name| roles.iter().any(|role| role.argument() == name))
}

/// Runs the process that the arguments describe to its end. Returns whether it wrote a report. `version`: version and
/// commit of this program, which is the same on all hosts of a run.
pub fn play(arguments: &[OsString], version: &str) -> bool {
    if arguments.get(1).is_some_and(|own| own == agent::ROLE) {
        return agent::run_agent_with(arguments, |context| Ok(BuiltIn::new(context)?)) == 0;
    }
    let role = match RoleArguments::try_parse_from(arguments) {
        Ok(role) => role,
        // Prints the problem and exits with code 2.
        Err(error) => error.exit(),
    };
    let membership = role.membership().as_part();
    part::play(&membership, &role.name(), || {
        role.play(&membership, version)
    })
}

/// Prints a problem. Standard error may be closed.
fn print_problem(role: &RoleArguments, problem: &str) {
    let _ = writeln!(std::io::stderr(), "slipstream {}: {problem}", role.name());
}

impl RoleArguments {
    fn play(&self, membership: &part::Membership, version: &str) -> Result<(), BusError> {
        let (run, recording) = (&membership.run, membership.recording);
        let launcher = membership.launcher;
        match self {
            Self::Plant(_) => self.report(&plant::run(run, launcher, recording)?),
            Self::Robots { lab, .. } => {
                let lab = Lab::read(lab).map_err(|error| BusError::failed("robots", error))?;
                let notice = |text: &str| print_problem(self, text);
                self.report(&robots::run(run, launcher, recording, &lab, &notice)?)
            }
            Self::Recorder {
                out, serve, waits, ..
            } => {
                let serve = serve.as_deref().map(|address| (address, *waits));
                self.report(&recorder::process::run(run, launcher, out, serve)?)
            }
            Self::Hosts {
                connection, host, ..
            } => {
                let mut carrier = network::listen(&connection.address, &connection.security())?;
                let stand_in = StandIn {
                    folder: run,
                    launcher,
                    hosts: host,
                    version,
                    run: rand::random(),
                    keys: read_keys(run),
                    recording,
                    keep: &|host, file| state_transfer::keep(run, host, file),
                    notice: &|text| print_problem(self, text),
                };
                let outcome = stand_in.run(&mut *carrier)?;
                self.report(&outcome)?;
                network::leave(carrier, outcome.ended == ProcessStatus::Done);
                Ok(())
            }
            Self::Relay {
                connection,
                name,
                number,
                ..
            } => {
                let (address, security) = (&connection.address, connection.security());
                let mut carrier = network::connect(address, &security, name)?;
                let relay = Relay {
                    folder: run,
                    launcher,
                    run: *number,
                    recording,
                    left: &|robots| state_transfer::left(run, robots),
                    failure: &|| report::read_failure(run, HOST),
                };
                let outcome = relay.run(&mut *carrier)?;
                self.report(&outcome)?;
                network::leave(carrier, outcome.ended == ProcessStatus::Done);
                Ok(())
            }
        }
    }

    fn report(&self, outcome: &impl Serialize) -> Result<(), BusError> {
        report::write(&self.membership().run, &self.name(), outcome)
    }

    fn membership(&self) -> &Membership {
        match self {
            Self::Plant(membership)
            | Self::Robots { membership, .. }
            | Self::Recorder { membership, .. }
            | Self::Hosts { membership, .. }
            | Self::Relay { membership, .. } => membership,
        }
    }

    /// Name of the process.
    fn name(&self) -> String {
        match self {
            Self::Plant(_) => Role::Plant.name(),
            Self::Robots { .. } => Role::Robots.name(),
            Self::Recorder { .. } => Role::Recorder.name(),
            Self::Hosts { .. } => Role::StandIn(0).name(),
            Self::Relay { .. } => Role::Relay.name(),
        }
    }
}
