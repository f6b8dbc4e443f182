//! Hosts that the launcher starts over ssh. A tunnel carries the connection, so that nothing listens beyond loopback.

use std::io::Read as _;
use std::ops::Range;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rand::RngExt as _;
use rustix::io::ioctl_fionbio;
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_hosts::address::Address;

use super::options::Across;
use crate::program::Programs;

/// Time that the hosts have to end after the run.
const END_TIMEOUT: Duration = Duration::from_millis(800);
const POLL_INTERVAL: Duration = Duration::from_millis(10);
/// Ports of the other host at which its end of the tunnel may listen: below those that systems give to connections.
const TUNNEL_PORTS: Range<u16> = 20_000..32_000;

/// The ssh processes of a run.
#[derive(Debug, Default)]
pub(super) struct SshHosts {
    running: Vec<SshHost>,
}

/// The ssh process of one host.
#[derive(Debug)]
struct SshHost {
    host: String,
    target: String,
    child: Child,
}

impl SshHosts {
    /// Starts `slipstream join` on every host that is to be started.
    ///
    /// # Errors
    /// There is no ssh.
    pub(super) fn start(across: &Across, programs: &Programs) -> std::io::Result<Self> {
        let mut guests = Self::default();
        for (host, target) in &across.ssh {
            let own = across.hosts.iter().find(|own| own.name == *host);
            let robots = own.map_or(&[][..], |own| &own.robots);
            let agents = agents(robots, programs);
            let child = command(&across.address, host, target, &agents).spawn()?;
            guests.running.push(SshHost {
                host: host.clone(),
                target: target.clone(),
                child,
            });
        }
        Ok(guests)
    }

    /// Why the ssh of a host has failed since the last call.
    pub(super) fn failures(&mut self) -> std::io::Result<Vec<String>> {
        let mut failures = Vec::new();
        let mut running = Vec::new();
        for mut guest in self.running.drain(..) {
            match guest.child.try_wait()? {
                None => running.push(guest),
                Some(status) if status.success() => {}
                Some(status) => failures.push(guest.failure(status.code())),
            }
        }
        self.running = running;
        Ok(failures)
    }
}

impl SshHost {
    fn failure(&mut self, code: Option<i32>) -> String {
        let mut said = Vec::new();
        if let Some(stderr) = &mut self.child.stderr {
            // A shared connection of ssh keeps it open: only what is there is read.
            let is_ready = ioctl_fionbio(&*stderr, true).is_ok();
            let _ = is_ready.then(|| stderr.read_to_end(&mut said));
        }
        let said = String::from_utf8_lossy(&said);
        let said: Vec<&str> = said
            .lines()
            .map(str::trim)
            .filter(|own| !own.is_empty())
            .collect();
        let said = said.join("; ");
        let remedy = match code {
            Some(255) => " (try this ssh by hand)",
            Some(127) => " (slipstream must be in the PATH that ssh gives)",
            _ => "",
        };
        format!("host {}: ssh {}: {said}{remedy}", self.host, self.target)
    }
}

impl Drop for SshHosts {
    /// Waits until the hosts have ended, but not for long. A tunnel ends with its ssh, and the host with the tunnel.
    fn drop(&mut self) {
        let begin = Instant::now();
        for guest in &mut self.running {
            while matches!(guest.child.try_wait(), Ok(None)) && begin.elapsed() < END_TIMEOUT {
                std::thread::sleep(POLL_INTERVAL);
            }
            let _ = guest.child.kill();
            let _ = guest.child.wait();
        }
    }
}

/// Arguments that give a host the programs of its robots, for the shell of that host.
fn agents(robots: &[RobotIndex], programs: &Programs) -> String {
    let argument = |robot: &RobotIndex| {
        let command = &programs.get(robot)?.command;
        let quoted = command.replace('\'', r"'\''");
        Some(format!(" --agent '{}={quoted}'", robot_name(*robot)))
    };
    robots.iter().filter_map(argument).collect()
}

/// The command that joins the run from a host.
fn command(address: &Address, host: &str, target: &str, agents: &str) -> Command {
    let place = address.place();
    let port = rand::rng().random_range(TUNNEL_PORTS);
    let mut command = Command::new("ssh");
    command
        .args([
            "-T",
            "-o",
            "BatchMode=yes",
            "-o",
            "ExitOnForwardFailure=yes",
        ])
        .arg("-R")
        .arg(format!("{port}:{place}"))
        .arg(target)
        .arg(format!(
            "slipstream join tcp/127.0.0.1:{port} --name {host}{agents}"
        ))
        // A process group of its own: Ctrl-C reaches the launcher alone.
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Program;

    #[test]
    fn a_host_gets_the_programs_of_its_robots() {
        let program = |command: &str| Program {
            command: command.to_owned(),
            ..Program::default()
        };
        let programs = Programs::from([(1, program("./a 'b'")), (2, program("d"))]);
        let expected = r" --agent 'r2=./a '\''b'\'''";
        assert_eq!(agents(&[1, 3], &programs), expected);
    }
}
