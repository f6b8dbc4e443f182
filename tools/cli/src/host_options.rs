//! Arguments of a run across hosts.

use std::path::PathBuf;

use clap::Args;
use slipstream_bus::InputError;
use slipstream_hosts::address::{Address, Security};
use slipstream_hosts::hello::{RemoteHost, is_host_name};
use slipstream_hosts::network;
use slipstream_launch::{Across, Resolved};

use crate::print::eprint_line;

/// Where the plant's host listens for others.
#[derive(Debug, Default, Args)]
pub(crate) struct Listening {
    /// Wait at this address for other hosts, which take part by slipstream join [default: a port of this computer alone]
    #[arg(
        long,
        value_name = "tcp/ADDRESS:PORT",
        requires = "host",
        conflicts_with = "in_process"
    )]
    listen: Option<String>,
    /// Run the controllers of these robots on the host that joins as NAME; may be repeated
    #[arg(long, value_name = "NAME=r2,r3", conflicts_with = "in_process")]
    host: Vec<String>,
    /// Start slipstream join on the host NAME over ssh, whose tunnel carries the connection; may be repeated
    #[arg(
        long,
        value_name = "NAME=USER@HOST",
        requires = "host",
        conflicts_with = "tls"
    )]
    ssh: Vec<String>,
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

/// An address of this computer alone, with a port that is free.
fn free_address() -> Result<Address, InputError> {
    let bound = std::net::TcpListener::bind("127.0.0.1:0").and_then(|own| own.local_addr());
    let unusable = |error| {
        let problem = format!("there is no free port: {error}");
        InputError::new("--host", problem, "give one with --listen")
    };
    bound.map_err(unusable)?.to_string().parse()
}

/// Says what to type on the hosts that are waited for.
fn invite(across: &Across) {
    let protection = match &across.security {
        Security::Loopback => String::new(),
        Security::Insecure => " --insecure".to_owned(),
        Security::Tls(folder) => format!(" --tls {}", folder.display()),
    };
    let is_started = |host: &&RemoteHost| across.ssh.iter().any(|(name, _)| *name == host.name);
    for host in across.hosts.iter().filter(|host| !is_started(host)) {
        let (address, name) = (&across.address, &host.name);
        eprint_line!(
            "slipstream: waits for host {name}: slipstream join {address} --name {name}{protection}"
        );
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
        if self.host.is_empty() {
            return Ok(None);
        }
        require_network("--host")?;
        let address: Address = match &self.listen {
            Some(listen) => listen.parse()?,
            None => free_address()?,
        };
        let security = self.protection.of(&address, "--listen")?;
        let hosts = self.hosts(resolved)?;
        let across = Across {
            ssh: self.ssh(&hosts)?,
            address,
            security,
            hosts,
        };
        invite(&across);
        Ok(Some(across))
    }

    /// The hosts that are started over ssh, with their destinations.
    fn ssh(&self, hosts: &[RemoteHost]) -> Result<Vec<(String, String)>, InputError> {
        let mut all: Vec<(String, String)> = Vec::new();
        for text in &self.ssh {
            let invalid =
                |problem, remedy| Err(InputError::new(format!("--ssh {text}"), problem, remedy));
            let Some((name, target)) = text.split_once('=') else {
                return invalid("has no =", "give --ssh NAME=USER@HOST");
            };
            if !hosts.iter().any(|host| host.name == name) {
                return invalid(
                    "names no host of the run",
                    "give its robots with --host NAME=r2,r3",
                );
            }
            if target.is_empty() || target.starts_with('-') {
                return invalid("is no destination of ssh", "give --ssh NAME=USER@HOST");
            }
            if all.iter().any(|(known, _)| known == name) {
                return invalid("starts a host again", "give each host once");
            }
            all.push((name.to_owned(), target.to_owned()));
        }
        Ok(all)
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
