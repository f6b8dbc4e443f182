//! A host joins the run of another: it asks the plant's host for its part and runs the agents.

use std::collections::BTreeMap;
use std::path::PathBuf;

use slipstream_bus::experiment::program_of;
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::{Experiment, InputError, Settings};
use slipstream_hosts::address::{Address, Security};
use slipstream_hosts::hello::Hello;
use slipstream_hosts::network;

use super::joined_host::JoinedHost;
use super::launcher;
use super::options::LaunchError;
use crate::program::{Program, Programs};
use crate::summary::RunStatus;

/// How a host joins the run of another.
#[derive(Debug, Clone)]
pub struct Joining {
    /// The program that plays the roles: this executable.
    pub program: PathBuf,
    /// Version and commit of this program.
    pub version: &'static str,
    /// Where the plant's host listens.
    pub address: Address,
    /// How the connection is protected.
    pub security: Security,
    /// The name of this host.
    pub name: String,
    /// Programs of agents on this host: the name of a robot, or `*` for all, and a command. What the other host runs is never
    /// started here.
    pub agents: Vec<(String, String)>,
    /// Draw a progress line on standard error.
    pub live: bool,
    /// Says what went wrong, as soon as it has.
    pub notice: fn(&str),
}

/// What a host did in the run of another.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// The experiment.
    pub experiment: Experiment,
    /// The robots whose agents ran on this host.
    pub robots: Vec<RobotIndex>,
    /// How it ended.
    pub status: RunStatus,
}

/// Joins the run of another host and runs its part of the agents to the end.
///
/// # Errors
/// The run cannot be joined, or the processes cannot be started.
pub fn join(joining: &Joining) -> Result<Joined, LaunchError> {
    let hello = Hello {
        version: joining.version.to_owned(),
        name: joining.name.clone(),
    };
    let welcome = network::ask(&joining.address, &joining.security, &hello)?;
    let place = joining.address.to_string();
    let unusable = |problem: &str| {
        let remedy = "use the same build on both hosts";
        InputError::new(place.clone(), problem, remedy)
    };
    let experiment: Experiment = postcard::from_bytes(&welcome.experiment)
        .map_err(|_| unusable("sends an experiment that this build cannot read"))?;
    let robots = experiment.settings.robots.count;
    if welcome.robots.is_empty() || welcome.robots.iter().any(|&robot| robot >= robots) {
        return Err(unusable("names robots that its experiment does not have").into());
    }
    let programs = programs(&experiment.settings, &welcome.robots, &joining.agents)?;
    let host = JoinedHost {
        programs,
        program: joining.program.clone(),
        address: joining.address.clone(),
        security: joining.security.clone(),
        name: joining.name.clone(),
        run: welcome.run,
        robots: welcome.robots,
        recording: welcome.recording,
        live: joining.live,
        notice: joining.notice,
    };
    let status = launcher::run_joined_host(&experiment, &welcome.keys, &host)?;
    Ok(Joined {
        experiment,
        robots: host.robots,
        status,
    })
}

/// The programs of the agents of this host. A robot that has one in the experiment needs one here.
fn programs(
    settings: &Settings,
    robots: &[RobotIndex],
    agents: &[(String, String)],
) -> Result<Programs, InputError> {
    let agents: BTreeMap<String, String> = agents.iter().cloned().collect();
    let mut programs = Programs::new();
    for &robot in robots {
        let Some(named) = settings.program(robot) else {
            continue;
        };
        let Some(command) = program_of(&agents, robot) else {
            let name = robot_name(robot);
            let problem = format!("is missing: the run has {named} for {name}");
            let remedy = format!("give the program on this host: --agent {name}=PROGRAM");
            return Err(InputError::new("--agent", problem, remedy));
        };
        let (command, folder) = (command.to_owned(), PathBuf::new());
        programs.insert(robot, Program { command, folder });
    }
    Ok(programs)
}
