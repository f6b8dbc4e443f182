//! `slipstream join`: runs controllers on this host for a run on another.

use std::io::IsTerminal;

use clap::Args;
use slipstream_bus::InputError;
use slipstream_bus::message::robot_name;
use slipstream_hosts::address::Address;
use slipstream_hosts::hello::is_host_name;
use slipstream_launch::RunStatus;
use slipstream_launch::processes::{self, Joining};

use crate::exit::{Error, Exit};
use crate::host_options::{Protection, require_network};
use crate::print::{eprint_line, print_line};
use crate::subject::named_programs;

/// Run the controllers of some robots on this host, for a run on another
///
/// The other host has the plant: it waits with slipstream run --listen ADDRESS --host NAME=r2,r3. Both hosts need
/// the same build of slipstream.
///
/// Example: slipstream join tcp/192.168.1.10:7447 --name b --tls keys
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Where the run waits
    #[arg(value_name = "tcp/ADDRESS:PORT")]
    address: String,
    /// Name of this host, as the run gives it with --host
    #[arg(long)]
    name: String,
    /// Program on this host that controls the robot NAME, or all robots of this host, where the run has one for them
    #[arg(long = "agent", value_name = "[NAME=]PROGRAM")]
    agents: Vec<String>,
    #[command(flatten)]
    protection: Protection,
}

/// Joins the run and takes part until it is over.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    require_network("slipstream join")?;
    let address: Address = arguments.address.parse()?;
    let security = arguments.protection.of(&address, "slipstream join")?;
    if !is_host_name(&arguments.name) {
        let place = format!("--name {}", arguments.name);
        let remedy = "give letters, digits, -, _ and .";
        return Err(InputError::new(place, "is not the name of a host", remedy).into());
    }
    let program = std::env::current_exe()
        .map_err(|error| Error::Failed(format!("failed to find this program: {error}")))?;
    let joined = processes::join(&Joining {
        program,
        version: env!("SLIPSTREAM_VERSION"),
        address,
        security,
        name: arguments.name.clone(),
        agents: named_programs(&arguments.agents),
        live: std::io::stderr().is_terminal(),
        notice: |text| eprint_line!("slipstream: {text}"),
    })?;
    let robots: Vec<String> = joined.robots.iter().map(|&own| robot_name(own)).collect();
    let settings = &joined.experiment.settings;
    Ok(match joined.status {
        RunStatus::Done => {
            print_line!(
                "Ran {} in {} for {} s as host {}.",
                robots.join(", "),
                settings.name,
                settings.duration_s,
                arguments.name
            );
            Exit::Done
        }
        RunStatus::Interrupted => Exit::Interrupted,
        RunStatus::Failed(_) => Exit::Failed,
    })
}
