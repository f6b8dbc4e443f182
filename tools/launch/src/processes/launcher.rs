//! The launcher: starts the processes of a run, watches them, stops them and removes what they share.

use std::fs::File;
use std::io::Read;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use slipstream_bag::output::lock_recording;
use slipstream_bus::experiment::{Clock, OnDeath};
use slipstream_bus::time::s_from_ns;
use slipstream_bus::{Experiment, InputError};
use slipstream_ipc::run_directory::{RunDirectory, RunLock, SHARED_MEMORY, leftovers};
use slipstream_ipc::wake_page::{Member, Stage, WakePage};
use slipstream_ipc::{report, trace};

use super::child::{ChildProcess, Start};
use super::joined_host::{HOST, JoinedHost};
use super::options::{LaunchError, Options};
use super::part::Part;
use super::progress_line::ProgressLine;
use super::ssh_hosts::SshHosts;
use super::{preflight, signals, state_transfer};
use crate::recorder;
use crate::recorder::trace_files;
use crate::resolve::Resolved;
use crate::role::Role;
use crate::run_files;
use crate::summary::{Process, RunStatus, RunSummary};

/// Longest wait between two updates of the progress line.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Largest number of failures that are told one by one.
const MAX_NOTICES: usize = 5;
/// Number of names that are tried for the run.
const NAMES: u32 = 3;
/// Largest number of restarts of one robot's agent.
const MAX_RESTARTS: u32 = 10;

fn system(step: &'static str) -> impl FnOnce(std::io::Error) -> LaunchError {
    move |error| LaunchError::System { step, error }
}

/// A run in progress. Dropping it kills every process and removes what they share.
pub(super) struct Run<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) part: Part<'a>,
    pub(super) directory: RunDirectory,
    pub(super) wake_page: WakePage,
    pub(super) children: Vec<ChildProcess>,
    /// All processes that were ever started.
    pub(super) processes: Vec<Process>,
    pub(super) status: RunStatus,
    /// What went wrong and has not been said yet.
    notices: Vec<String>,
    /// Number of things that went wrong.
    failures: usize,
    /// When a stop was requested before the planned end.
    pub(super) stopped: Option<Instant>,
    /// Whether all processes were connected when the stop was requested.
    stopped_running: bool,
    /// When the plant had made its last step.
    pub(super) over: Option<Instant>,
    /// When the last process but the recorder ended.
    pub(super) drained: Option<Instant>,
    /// Hosts that were started over ssh.
    ssh_hosts: SshHosts,
    /// The recording, locked while it is open.
    recording: Option<File>,
    _lock: RunLock,
}

/// Runs an experiment as processes of its own.
///
/// # Errors
/// When the run cannot be started. Later failures are in the summary's status.
pub fn run(resolved: &Resolved, options: &Options) -> Result<RunSummary, LaunchError> {
    let experiment = &resolved.experiment;
    preflight::check(&experiment.settings)?;
    let keys = resolved.to_toml();
    let begin_recording = |out: &PathBuf| {
        let begun = recorder::begin(experiment, &keys, out)?;
        lock_recording(out, &begun)
    };
    let recording = options.out.as_ref().map(begin_recording).transpose()?;
    let _tracing = match options.out {
        Some(_) => trace_files::begin(experiment, "launcher")?,
        None => None,
    };
    let mut signals = signals::listen().map_err(system("listen for signals"))?;
    let begin = Instant::now();
    let mut run = Run::prepare(
        experiment,
        &keys,
        Part::Home(options, &resolved.programs),
        recording,
    )?;
    run.watch(options.live, &mut signals)?;
    let mut summary = run.summarise(options);
    summary.wall_s = begin.elapsed().as_secs_f64();
    run.say_notices();
    Ok(summary)
}

/// Runs the agents of a host that has joined the run of another. Returns how it ended.
///
/// # Errors
/// When they cannot be started.
pub(super) fn run_joined_host(
    experiment: &Experiment,
    keys: &str,
    host: &JoinedHost,
) -> Result<RunStatus, LaunchError> {
    preflight::check(&experiment.settings)?;
    let mut signals = signals::listen().map_err(system("listen for signals"))?;
    let mut run = Run::prepare(experiment, keys, Part::JoinedHost(host), None)?;
    run.wake_page.set_local(&host.robots);
    run.watch(host.live, &mut signals)?;
    run.say_notices();
    Ok(run.status.clone())
}

impl<'a> Run<'a> {
    fn prepare(
        experiment: &'a Experiment,
        keys: &str,
        part: Part<'a>,
        recording: Option<File>,
    ) -> Result<Self, LaunchError> {
        let unwritable = |error: std::io::Error| {
            let remedy = "check its permissions and free space (slipstream clean)";
            InputError::new(SHARED_MEMORY, format!("cannot be written: {error}"), remedy)
        };
        remove_leftovers();
        let (directory, lock) = create_directory().map_err(unwritable)?;
        let files = run_files::write(&directory, experiment, keys);
        let robots = experiment.robots.len();
        let wake_page = files.and_then(|()| WakePage::create(&directory.wake_page(), robots));
        let wake_page = match wake_page {
            Ok(wake_page) => wake_page,
            Err(error) => {
                let _ = directory.remove();
                return Err(unwritable(error).into());
            }
        };
        Ok(Self {
            experiment,
            part,
            directory,
            wake_page,
            children: Vec::new(),
            processes: Vec::new(),
            status: RunStatus::Done,
            notices: Vec::new(),
            failures: 0,
            stopped: None,
            stopped_running: false,
            over: None,
            drained: None,
            ssh_hosts: SshHosts::default(),
            recording,
            _lock: lock,
        })
    }

    /// Starts the processes and waits until they have ended.
    fn watch(&mut self, live: bool, signals: &mut UnixStream) -> Result<(), LaunchError> {
        let roles = self.part.roles(self.experiment);
        let started = roles.into_iter().try_for_each(|role| self.spawn(role, 0));
        started.map_err(system("start the processes"))?;
        if let Some(across) = self.part.across() {
            let programs = self.part.programs();
            self.ssh_hosts = SshHosts::start(across, programs).map_err(system("start ssh"))?;
        }
        let progress = ProgressLine::new(live, &self.experiment.settings);
        while self.children.iter().any(is_awaited) {
            self.wait(signals)
                .map_err(system("wait for the processes"))?;
            for notice in self.notices.drain(..) {
                progress.suspend(|| self.part.say(&notice));
            }
            progress.draw(&self.wake_page);
        }
        progress.clear();
        Ok(())
    }

    /// Says what has not been said yet.
    fn say_notices(&mut self) {
        if self.failures > MAX_NOTICES {
            let more = self.failures - MAX_NOTICES;
            self.notices
                .push(format!("and {more} more processes failed"));
        }
        for notice in self.notices.drain(..) {
            self.part.say(&notice);
        }
    }

    fn spawn(&mut self, role: Role, restarts: u32) -> std::io::Result<()> {
        let start = Start {
            program: self.part.program(),
            agent: self.part.agent(role),
            directory: &self.directory,
            recording: self.part.is_recorded(),
            trace: self.experiment.settings.recording.trace,
            arguments: &self.part.arguments(role),
            // The recorder writes to the file that the launcher opened, and so shares its lock.
            input: self.recording.as_ref().filter(|_| role == Role::Recorder),
        };
        let child = ChildProcess::spawn(start, role, restarts)?;
        let process = child.describe();
        if let (Part::JoinedHost(_), Role::Agent(robot)) = (self.part, role) {
            state_transfer::note_pid(self.directory.folder(), robot, process.pid);
        }
        self.processes.push(process);
        self.children.push(child);
        Ok(())
    }

    /// Waits for an event, at most for [`POLL_INTERVAL`], and handles it.
    fn wait(&mut self, signals: &mut UnixStream) -> std::io::Result<()> {
        let ended = self.poll(signals)?;
        let mut buffer = [0; 16];
        if matches!(signals.read(&mut buffer), Ok(1..)) {
            if self.status == RunStatus::Interrupted {
                self.kill_all(", because the run was interrupted twice");
            }
            self.status = RunStatus::Interrupted;
            self.stop();
        }
        for index in ended {
            let status = self.children[index].wait()?;
            trace::set_virtual_time(self.wake_page.progress().0);
            let role = self.children[index].role;
            tracing::info!(name: "ended", role = role.argument(), robot = role.robot(), status = %status);
            self.after_end(index)?;
        }
        let working = |child: &ChildProcess| !child.role.ends_last() && is_awaited(child);
        if self.drained.is_none() && !self.children.iter().any(working) {
            self.drained = Some(Instant::now());
            trace::save(self.directory.folder(), "launcher");
            self.wake_page.advance(Stage::Drained);
        }
        if self.over.is_none() && self.wake_page.stage() >= Stage::Over {
            self.over = Some(Instant::now());
        }
        for reason in self.ssh_hosts.failures()? {
            // What follows from a run that ends is not worth a sentence.
            if self.stopped.is_none() && self.over.is_none() {
                self.fail(reason);
                self.stop();
            }
        }
        self.kill_hanging();
        Ok(())
    }

    /// The children that have ended since the last call.
    fn poll(&self, signals: &UnixStream) -> std::io::Result<Vec<usize>> {
        let running: Vec<usize> = (0..self.children.len())
            .filter(|&i| self.children[i].is_running())
            .collect();
        let pidfds = running.iter().map(|&i| self.children[i].pidfd.as_fd());
        let mut fds: Vec<PollFd<'_>> = pidfds
            .chain(std::iter::once(signals.as_fd()))
            .map(|fd| PollFd::from_borrowed_fd(fd, PollFlags::IN))
            .collect();
        let timeout = Timespec {
            tv_sec: 0,
            tv_nsec: i64::from(POLL_INTERVAL.subsec_nanos()),
        };
        match poll(&mut fds, Some(&timeout)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let ended = running
            .iter()
            .zip(&fds)
            .filter(|(_, fd)| !fd.revents().is_empty());
        Ok(ended.map(|(&index, _)| index).collect())
    }

    /// Handles the end of a child: a planned end needs nothing; after a failure the run stops, continues, or
    /// restarts the agent.
    fn after_end(&mut self, index: usize) -> std::io::Result<()> {
        let role = self.children[index].role;
        if role.ends_last() {
            self.wake_page.set_recorder_gone();
        }
        let time_s = s_from_ns(self.wake_page.progress().0);
        let Some(reason) = self.children[index].failure(self.directory.folder(), time_s) else {
            return Ok(());
        };
        // What fails because the run stops is not worth a sentence. What hangs is, unless it was still
        // waiting for the others to start.
        let hung = self.stopped_running && self.children[index].was_killed();
        if self.stopped.is_none() || hung {
            self.fail(reason + &self.planted());
        }
        match role.member() {
            Member::Agent(robot) => self.wake_page.count_death(Some(robot)),
            Member::Plant => self.wake_page.count_death(None),
            Member::Recorder => {}
        }
        let settings = &self.experiment.settings;
        let continues = settings.clock == Clock::Wall
            && settings.on_death != OnDeath::Stop
            && !role.leads()
            && self.wake_page.stage() == Stage::Running
            && self.stopped.is_none();
        if !continues {
            self.stop();
            if role.leads() {
                self.wake_page.advance(Stage::Over);
            }
            return Ok(());
        }
        let restarts = self.children[index].restarts;
        let restart = settings.on_death == OnDeath::Restart && restarts < MAX_RESTARTS;
        if matches!(role, Role::Agent(_)) && restart {
            self.spawn(role, restarts + 1)?;
        }
        Ok(())
    }

    /// Says why the run fails. The first reason becomes its status.
    pub(super) fn fail(&mut self, reason: String) {
        self.failures += 1;
        if self.failures <= MAX_NOTICES {
            self.notices.push(reason.clone());
        }
        if self.status == RunStatus::Done {
            if matches!(self.part, Part::JoinedHost(_)) {
                // The relay sends it home. If it cannot be written, the plant's host hears less.
                let _ = report::write_failure(self.directory.folder(), HOST, &reason);
            }
            self.status = RunStatus::Failed(reason);
        }
    }

    /// What another user put among the files of the run, as the end of a sentence.
    fn planted(&self) -> String {
        let planted = self.directory.planted().unwrap_or_default();
        planted.first().map_or_else(String::new, |path| {
            let path = path.display();
            format!("; another user has put {path} there: start the run again")
        })
    }

    fn stop(&mut self) {
        if self.stopped.is_none() {
            self.stopped = Some(Instant::now());
            self.stopped_running = self.wake_page.stage() >= Stage::Running;
        }
        self.wake_page.stop();
    }

    fn kill_all(&mut self, reason: &str) {
        for child in &mut self.children {
            child.kill("was killed", reason);
        }
    }
}

/// Whether the launcher waits for the end of a process.
fn is_awaited(child: &ChildProcess) -> bool {
    child.is_running() && !child.is_given_up()
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        self.kill_all("");
        for child in &mut self.children {
            if child.is_running() && !child.wait_killed() {
                let name = child.role.name();
                let state = child.state();
                self.part.say(&format!("{name} cannot be killed: {state}"));
            }
        }
        if let Err(error) = self.directory.remove() {
            let folder = self.directory.folder().display();
            self.part.say(&format!(
                "{folder}: {error}; remove it with slipstream clean"
            ));
        }
    }
}

/// Removes what dead runs left behind.
fn remove_leftovers() {
    for run in leftovers().unwrap_or_default() {
        if !run.foreign {
            tracing::info!(name: "removed", files = run.paths.len());
            // What stays is listed by `slipstream clean`.
            let _ = run.remove();
        }
    }
}

/// Creates the directory of the run under a name that no other run has.
fn create_directory() -> std::io::Result<(RunDirectory, RunLock)> {
    let mut result = RunDirectory::create(rand::random());
    for _ in 1..NAMES {
        if result.is_ok() {
            break;
        }
        result = RunDirectory::create(rand::random());
    }
    result
}
