//! The part of a run that a launcher has: plant and recorder with the agents of its host, or only agents.

use std::ffi::OsString;
use std::path::Path;

use slipstream_bus::Experiment;
use slipstream_bus::message::RobotIndex;

use super::joined_host::JoinedHost;
use super::options::{Across, Options};
use crate::program::{Program, Programs};
use crate::role::Role;

/// The part of a run on this host.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part<'a> {
    /// Plant and recorder, and the agents that no other host has.
    Home(&'a Options, &'a Programs),
    /// Agents alone.
    JoinedHost(&'a JoinedHost),
}

impl Part<'_> {
    /// The processes in the order of their start. All wait for the services of the first one.
    pub(super) fn roles(self, experiment: &Experiment) -> Vec<Role> {
        let mut roles = Vec::new();
        match self {
            Self::Home(options, _) => {
                let elsewhere = options.robots_elsewhere();
                roles.push(match options.real {
                    Some(_) => Role::Robots,
                    None => Role::Plant,
                });
                roles.extend(options.out.as_ref().map(|_| Role::Recorder));
                roles.extend(elsewhere.first().map(|&first| Role::StandIn(first)));
                let robots = 0..experiment.settings.robots.count;
                let here = robots.filter(|robot| !elsewhere.contains(robot));
                roles.extend(here.map(Role::Agent));
            }
            Self::JoinedHost(host) => {
                roles.push(Role::Relay);
                roles.extend(host.robots.iter().map(|&robot| Role::Agent(robot)));
            }
        }
        roles
    }

    /// The program that plays the roles.
    pub(super) fn program(&self) -> &Path {
        match self {
            Self::Home(options, _) => &options.program,
            Self::JoinedHost(host) => &host.program,
        }
    }

    /// The own program of a robot's agent, if it has one.
    pub(super) fn agent(&self, role: Role) -> Option<&Program> {
        self.programs().get(&role.robot()?)
    }

    /// The own programs of agents.
    pub(super) fn programs(&self) -> &Programs {
        match self {
            Self::Home(_, programs) => programs,
            Self::JoinedHost(host) => &host.programs,
        }
    }

    /// The other hosts of the run, if this is the plant's.
    pub(super) fn across(&self) -> Option<&Across> {
        match self {
            Self::Home(options, _) => options.across.as_ref(),
            Self::JoinedHost(_) => None,
        }
    }

    /// Whether the run is recorded.
    pub(super) fn is_recorded(self) -> bool {
        match self {
            Self::Home(options, _) => options.out.is_some(),
            Self::JoinedHost(host) => host.recording,
        }
    }

    /// Whether real robots take the place of the plant.
    pub(super) fn is_real(self) -> bool {
        matches!(self, Self::Home(options, _) if options.real.is_some())
    }

    /// Arguments of one role alone.
    pub(super) fn arguments(self, role: Role) -> Vec<OsString> {
        match (self, role) {
            (Self::Home(options, _), Role::Recorder) => options.recorder_arguments(),
            (Self::Home(options, _), Role::Robots) => options.robots_arguments(),
            (Self::Home(options, _), Role::StandIn(_)) => options.stand_in_arguments(),
            (Self::JoinedHost(host), Role::Relay) => host.relay_arguments(),
            _ => Vec::new(),
        }
    }

    /// Says something to the user.
    pub(super) fn say(self, text: &str) {
        match self {
            Self::Home(options, _) => (options.notice)(text),
            Self::JoinedHost(host) => (host.notice)(text),
        }
    }
}

impl Options {
    /// The robots whose agents run on other hosts.
    fn robots_elsewhere(&self) -> Vec<RobotIndex> {
        let hosts = self.across.iter().flat_map(|across| &across.hosts);
        hosts.flat_map(|host| host.robots.iter().copied()).collect()
    }

    fn recorder_arguments(&self) -> Vec<OsString> {
        let mut arguments = Vec::new();
        if let Some(out) = &self.out {
            arguments.extend(["--out".into(), out.into()]);
        }
        if let Some(serve) = &self.serve {
            arguments.extend(["--serve".into(), OsString::from(&serve.address)]);
            arguments.extend(serve.waits.then(|| "--waits".into()));
        }
        arguments
    }

    fn robots_arguments(&self) -> Vec<OsString> {
        let lab = self.real.iter();
        lab.flat_map(|lab| ["--lab".into(), lab.into()]).collect()
    }

    fn stand_in_arguments(&self) -> Vec<OsString> {
        let Some(across) = &self.across else {
            return Vec::new();
        };
        let mut arguments = vec!["--address".into(), across.address.to_string().into()];
        arguments.extend(across.security.arguments());
        for host in &across.hosts {
            let robots: Vec<String> = host.robots.iter().map(ToString::to_string).collect();
            arguments.push("--host".into());
            arguments.push(format!("{}={}", host.name, robots.join(",")).into());
        }
        arguments
    }
}
