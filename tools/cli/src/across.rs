//! Arguments of a run across hosts.

use std::path::PathBuf;

use clap::Args;
use slipstream_bus::InputError;
use slipstream_bus::experiment::Clock;
use slipstream_hosts::address::{Address, Security};
use slipstream_hosts::hello::{RemoteHost, is_host_name};
use slipstream_hosts::network;
use slipstream_launch::{Across, Resolved};

/// Where the plant's host listens for others.
#[derive(Debug, Default, Args)]
pub(crate) struct Listening {
    /// Wait at this address for other hosts, which take part by slipstream join
    #[arg(
        long,
        value_name = "tcp/ADDRESS:PORT",
        requires = "host",
        conflicts_with = "in_process"
    )]
    listen: Option<String>,
    /// Run the controllers of these robots on the host that joins as NAME; may be repeated
    #[arg(long, value_name = "NAME=r2,r3", requires = "listen")]
    host: Vec<String>,
    #[command(flatten)]
    protection: Protection,
}

/// How connections between hosts are protected.
#[derive(Debug, Default, Args)]
pub(crate) struct Protection {
    /// Connections between hosts: TLS, with the certificates of slipstream keys in this folder
    #[arg(long, value_name = "FOLDER")]
    tls: Option<PathBuf>,
    /// Connections between hosts: without protection, in a network that you trust
    #[arg(long, conflicts_with = "tls")]
    insecure: bool,
}

impl Protection {
    /// The protection of connections with `address`, which `argument` gives.
    pub(crate) fn of(&self, address: &Address, argument: &str) -> Result<Security, InputError> {
        let security = Security::new(self.tls.clone(), self.insecure);
        security.check(address, argument)?;
        if let Security::Tls(folder) = &security {
            network::check_certificates(folder)?;
        }
        Ok(security)
    }
}

/// Refuses in a build that has no network for hosts.
pub(crate) fn require_network(argument: &str) -> Result<(), InputError> {
    if network::IS_BUILT {
        return Ok(());
    }
    let remedy = "build it with cargo install --path tools/cli --features hosts";
    Err(InputError::new(
        argument,
        "needs a slipstream that was built for several hosts",
        remedy,
    ))
}

impl Listening {
    /// The other hosts of a run, if there are any.
    pub(crate) fn across(&self, resolved: &Resolved) -> Result<Option<Across>, InputError> {
        let Some(listen) = &self.listen else {
            return Ok(None);
        };
        require_network("--listen")?;
        let address: Address = listen.parse()?;
        let security = self.protection.of(&address, "--listen")?;
        if resolved.experiment.settings.clock == Clock::Wall {
            return Err(InputError::new(
                "--listen",
                "runs on the virtual clock only: across hosts every round waits for all robots",
                "drop --clock wall",
            ));
        }
        Ok(Some(Across {
            address,
            security,
            hosts: self.hosts(resolved)?,
        }))
    }

    fn hosts(&self, resolved: &Resolved) -> Result<Vec<RemoteHost>, InputError> {
        let mut hosts: Vec<RemoteHost> = Vec::new();
        let names: Vec<&str> = resolved
            .experiment
            .robots
            .iter()
            .map(|robot| robot.name.as_str())
            .collect();
        for text in &self.host {
            let place = format!("--host {text}");
            let invalid = |problem: String, remedy: &str| {
                Err(InputError::new(place.clone(), problem, remedy))
            };
            let Some((name, listed)) = text.split_once('=').filter(|(name, _)| is_host_name(name))
            else {
                let remedy = "give NAME=r2,r3 with a name of letters, digits, -, _ and .";
                return invalid("is not a host with its robots".to_owned(), remedy);
            };
            if hosts.iter().any(|host| host.name == name) {
                return invalid(format!("names {name} again"), "give each host once");
            }
            let mut robots = Vec::new();
            for robot in listed.split(',') {
                let Some(index) = (0u32..).zip(&names).find(|(_, own)| **own == robot) else {
                    let remedy =
                        format!("the robots are {} to {}", names[0], names[names.len() - 1]);
                    return invalid(format!("has no robot {robot:?}"), &remedy);
                };
                let twice = hosts.iter().any(|host| host.robots.contains(&index.0));
                if twice || robots.contains(&index.0) {
                    return invalid(format!("names {robot} again"), "give each robot one host");
                }
                robots.push(index.0);
            }
            let name = name.to_owned();
            hosts.push(RemoteHost { name, robots });
        }
        Ok(hosts)
    }
}
