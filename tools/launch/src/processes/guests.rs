//! Hosts that the launcher starts over ssh. A tunnel carries the connection, so that nothing listens beyond loopback.

use std::io::Read as _;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};

use slipstream_hosts::address::Address;

use super::options::Across;

/// The ssh processes of a run.
#[derive(Debug, Default)]
pub(super) struct Guests {
    running: Vec<Guest>,
}

/// The ssh process of one host.
#[derive(Debug)]
struct Guest {
    host: String,
    target: String,
    child: Child,
}

impl Guests {
    /// Starts `slipstream join` on every host that is to be started.
    ///
    /// # Errors
    /// There is no ssh.
    pub(super) fn start(across: &Across) -> std::io::Result<Self> {
        let mut guests = Self::default();
        for (host, target) in &across.ssh {
            let child = command(&across.address, host, target).spawn()?;
            guests.running.push(Guest {
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

impl Guest {
    fn failure(&mut self, code: Option<i32>) -> String {
        let mut said = String::new();
        if let Some(stderr) = &mut self.child.stderr {
            // What cannot be read is not said.
            let _ = stderr.read_to_string(&mut said);
        }
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

impl Drop for Guests {
    fn drop(&mut self) {
        for guest in &mut self.running {
            // Its tunnel ends with it, and the host with the tunnel.
            let _ = guest.child.kill();
            let _ = guest.child.wait();
        }
    }
}

/// The command that joins the run from a host.
fn command(address: &Address, host: &str, target: &str) -> Command {
    let place = address.place();
    let port = address.port();
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
            "slipstream join tcp/127.0.0.1:{port} --name {host}"
        ))
        // A process group of its own: Ctrl-C reaches the launcher alone.
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}
