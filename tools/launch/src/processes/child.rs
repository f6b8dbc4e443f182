//! One child process of a run: how it is started, and why it ended.

use std::os::fd::OwnedFd;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};

use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use slipstream_agents::process::AgentOutcome;
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_sim::run::process::PlantOutcome;

use super::options::Options;
use super::report;
use crate::recorder::RecorderOutcome;
use crate::role::Role;
use crate::summary::Process;

/// A process of the run.
#[derive(Debug)]
pub(super) struct ChildProcess {
    pub(super) role: Role,
    child: Child,
    /// Becomes readable when the process ends.
    pub(super) pidfd: OwnedFd,
    /// How it ended; `None` while it runs.
    pub(super) status: Option<ExitStatus>,
    /// How often an agent of this robot was restarted before.
    pub(super) restarts: u32,
}

/// What a child is started with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start<'a> {
    pub(super) options: &'a Options,
    pub(super) directory: &'a RunDirectory,
    /// The recording holds a trace.
    pub(super) trace: bool,
}

impl ChildProcess {
    /// Starts a process in the given role. `restarts`: how often it was restarted, 0 at first.
    pub(super) fn spawn(start: Start<'_>, role: Role, restarts: u32) -> std::io::Result<Self> {
        let mut command = Command::new(&start.options.program);
        command
            .arg(role.argument())
            .arg("--run")
            .arg(start.directory.folder());
        if let Role::Agent(robot) = role {
            command.arg("--robot").arg(robot.to_string());
        }
        if restarts > 0 {
            command.arg("--rejoins");
        }
        if let Some(out) = &start.options.out {
            command.arg("--recording");
            if start.trace {
                command.arg("--trace");
            }
            if role == Role::Recorder {
                command.arg("--out").arg(out);
            }
        }
        // A process group of its own: Ctrl-C reaches the launcher alone.
        command
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        let child = command.spawn()?;
        let pidfd = pidfd_open(Pid::from_child(&child), PidfdFlags::empty())?;
        tracing::info!(name: "started", role = role.argument(), robot = role.robot(), pid = child.id());
        Ok(Self {
            role,
            child,
            pidfd,
            status: None,
            restarts,
        })
    }

    /// The process for the summary.
    pub(super) fn describe(&self) -> Process {
        Process::new(self.role, self.child.id())
    }

    /// Whether it still runs.
    pub(super) fn is_running(&self) -> bool {
        self.status.is_none()
    }

    /// Waits for its end.
    pub(super) fn wait(&mut self) -> std::io::Result<ExitStatus> {
        let status = self.child.wait()?;
        self.status = Some(status);
        Ok(status)
    }

    /// Sends SIGKILL if it still runs.
    pub(super) fn kill(&self) {
        if self.is_running() {
            // It may have ended just now.
            let _ = kill_process(Pid::from_child(&self.child), Signal::KILL);
        }
    }

    /// Why its end counts as a failure; `None` if it ended as planned. `time_s` is the time of the run.
    pub(super) fn failure(&self, directory: &RunDirectory, time_s: f64) -> Option<String> {
        let status = self.status?;
        let (name, pid) = (self.role.name(), self.child.id());
        if let Some(signal) = status.signal() {
            return Some(format!(
                "{name} (pid {pid}) was killed by signal {signal} at {time_s:.3} s"
            ));
        }
        if !status.success() {
            return Some(format!("{name} (pid {pid}) failed at {time_s:.3} s"));
        }
        let ended = match self.role {
            Role::Plant => report::read(directory, &name).map(|plant: PlantOutcome| plant.ended),
            Role::Agent(_) => report::read(directory, &name).map(|agent: AgentOutcome| agent.ended),
            Role::Recorder => report::read(directory, &name).map(|recorder: RecorderOutcome| {
                recorder
                    .failure
                    .map_or(ProcessStatus::Done, ProcessStatus::Failed)
            }),
        };
        match ended {
            Some(ProcessStatus::Failed(reason)) => Some(format!("{name} (pid {pid}): {reason}")),
            _ => None,
        }
    }
}
