//! One child process of a run: how it is started, and why it ended.

use std::ffi::OsString;
use std::fs::File;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open};
use slipstream_agents::process::{AgentOutcome, Arguments};
use slipstream_hosts::relay::RelayOutcome;
use slipstream_hosts::stand_in::StandInOutcome;
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::report;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_robots::process::RobotsOutcome;
use slipstream_sim::run::process::PlantOutcome;

use super::silence::Silence;
use crate::program::Program;
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
    /// How long it has shown no sign of life.
    pub(super) silence: Silence,
    /// The command of an agent's own program.
    program: Option<String>,
    /// When and why the launcher killed it: a verb, and what follows the time.
    killed: Option<(Instant, &'static str, String)>,
}

/// Time that a killed process has to vanish. One that waits for a dead disk cannot be killed.
const KILL_TIMEOUT: Duration = Duration::from_secs(2);

/// What a child is started with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start<'a> {
    /// The program that plays the roles.
    pub(super) program: &'a Path,
    /// The agent's own program, if it has one.
    pub(super) agent: Option<&'a Program>,
    pub(super) directory: &'a RunDirectory,
    /// The run is recorded.
    pub(super) recording: bool,
    /// The recording holds a trace.
    pub(super) trace: bool,
    /// Arguments of this role alone.
    pub(super) arguments: &'a [OsString],
    /// Its standard input: the recording, open and locked.
    pub(super) input: Option<&'a File>,
}

impl ChildProcess {
    /// Starts a process in the given role. `restarts`: how often it was restarted, 0 at first.
    pub(super) fn spawn(start: Start<'_>, role: Role, restarts: u32) -> std::io::Result<Self> {
        let folder = start.directory.folder();
        let mut command = match start.agent {
            Some(program) => program.command(),
            None => Command::new(start.program),
        };
        if let Role::Agent(robot) = role {
            let launcher = Some(std::process::id());
            command.args(Arguments::to_start(folder, robot, launcher));
        } else {
            command.arg(role.argument()).arg("--run").arg(folder);
            command
                .arg("--launcher")
                .arg(std::process::id().to_string());
        }
        if restarts > 0 {
            command.arg("--rejoins");
        }
        command.args(start.recording.then_some("--recording"));
        command.args((start.recording && start.trace).then_some("--trace"));
        command.args(start.arguments);
        let stdin = match start.input {
            Some(file) => file.try_clone()?.into(),
            None => Stdio::null(),
        };
        // A process group of its own: Ctrl-C reaches the launcher alone.
        command.process_group(0).stdin(stdin);
        // What a program of the user's prints is for the user, beside the messages of the run.
        command.stdout(match start.agent {
            Some(_) => std::io::stderr().as_fd().try_clone_to_owned()?.into(),
            None => Stdio::null(),
        });
        let mut child = command.spawn()?;
        let pidfd = match pidfd_open(Pid::from_child(&child), PidfdFlags::empty()) {
            Ok(pidfd) => pidfd,
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(error.into());
            }
        };
        tracing::info!(name: "started", role = role.argument(), robot = role.robot(), pid = child.id());
        Ok(Self {
            role,
            child,
            pidfd,
            status: None,
            restarts,
            silence: Silence::new(Instant::now()),
            program: start.agent.map(|program| program.command.clone()),
            killed: None,
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

    /// Takes its end, when it has ended. What an agent's own program has started and left is killed.
    pub(super) fn wait(&mut self) -> std::io::Result<ExitStatus> {
        if self.program.is_some() {
            // Until its end is taken, no other process can have its id.
            self.kill_group();
        }
        let status = self.child.wait()?;
        self.status = Some(status);
        Ok(status)
    }

    /// Waits for the end of a killed process, at most for [`KILL_TIMEOUT`]. Returns whether it has
    /// ended.
    pub(super) fn wait_killed(&mut self) -> bool {
        let timeout = Timespec::try_from(KILL_TIMEOUT).ok();
        let mut fds = [PollFd::from_borrowed_fd(self.pidfd.as_fd(), PollFlags::IN)];
        let ended = matches!(poll(&mut fds, timeout.as_ref()), Ok(1..));
        ended && self.wait().is_ok()
    }

    /// Sends SIGKILL if it still runs. What the process did is said as `verb`, time of the run,
    /// `details`.
    pub(super) fn kill(&mut self, verb: &'static str, details: impl Into<String>) {
        if self.is_running() && self.killed.is_none() {
            self.killed = Some((Instant::now(), verb, details.into()));
            self.kill_group();
        }
    }

    /// Kills it with all that it has started.
    fn kill_group(&self) {
        // It may have ended just now.
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
    }

    /// Whether the launcher killed it.
    pub(super) fn was_killed(&self) -> bool {
        self.killed.is_some()
    }

    /// Whether it still runs though it was killed some time ago, so that nobody should wait for it.
    pub(super) fn is_given_up(&self) -> bool {
        let late = |(since, ..): &(Instant, _, _)| since.elapsed() > KILL_TIMEOUT;
        self.is_running() && self.killed.as_ref().is_some_and(late)
    }

    /// What the process does, by the operating system: for one that hangs.
    pub(super) fn state(&self) -> &'static str {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id()));
        let stat = stat.unwrap_or_default();
        match stat
            .rsplit(") ")
            .next()
            .and_then(|rest| rest.chars().next())
        {
            Some('T' | 't') => "it was stopped by a signal or a debugger",
            Some('D') => "it waits for a disk or another device",
            Some('R') => "it computes without an end, or gets no processor time",
            _ => "it waits",
        }
    }

    /// Why its end counts as a failure; `None` if it ended as planned. `time_s` is the time of the run.
    pub(super) fn failure(&self, folder: &Path, time_s: f64) -> Option<String> {
        let status = self.status?;
        let name = self.role.name();
        let pid = match &self.program {
            Some(program) => format!("{}, {program}", self.child.id()),
            None => self.child.id().to_string(),
        };
        if let Some((_, verb, details)) = &self.killed {
            return Some(format!(
                "{name} (pid {pid}) {verb} at {time_s:.3} s{details}"
            ));
        }
        if let Some(signal) = status.signal() {
            let cause = likely_cause(signal);
            return Some(format!(
                "{name} (pid {pid}) was killed by signal {signal}{cause} at {time_s:.3} s"
            ));
        }
        if !status.success() {
            return Some(match report::read_failure(folder, &name) {
                Some(reason) => format!("{name} (pid {pid}): {reason}"),
                None => {
                    let code = status.code().unwrap_or(1);
                    format!("{name} (pid {pid}) ended with exit code {code} at {time_s:.3} s")
                }
            });
        }
        let ended = match self.role {
            Role::Plant => report::read(folder, &name).map(|plant: PlantOutcome| plant.ended),
            Role::Robots => report::read(folder, &name).map(|robots: RobotsOutcome| robots.ended),
            Role::Agent(_) => report::read(folder, &name).map(|agent: AgentOutcome| agent.ended),
            Role::StandIn(_) => report::read(folder, &name).map(|own: StandInOutcome| own.ended),
            Role::Relay => report::read(folder, &name).map(|own: RelayOutcome| own.ended),
            Role::Recorder => report::read(folder, &name).map(|recorder: RecorderOutcome| {
                recorder
                    .failure
                    .map_or(ProcessStatus::Done, ProcessStatus::Failed)
            }),
        };
        match ended {
            None if self.program.is_some() => Some(format!(
                "{name} (pid {pid}) ended by itself at {time_s:.3} s: is it the program of an agent?"
            )),
            Some(ProcessStatus::Failed(reason)) => Some(format!("{name} (pid {pid}): {reason}")),
            _ => None,
        }
    }
}

/// The likely cause of a signal, in brackets.
fn likely_cause(signal: i32) -> &'static str {
    match Signal::from_named_raw(signal) {
        Some(Signal::BUS) => " (SIGBUS, as when /dev/shm is full or a file in it was cut)",
        Some(Signal::KILL) => " (SIGKILL, by hand or by the system for want of memory)",
        Some(Signal::SEGV) => " (SIGSEGV)",
        Some(Signal::ABORT) => " (SIGABRT)",
        _ => "",
    }
}
