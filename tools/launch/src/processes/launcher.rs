//! The launcher: starts the processes of a run, watches them, stops them and removes what they share.

use std::io::{Read, Write as _};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use slipstream_agents::process::AgentOutcome;
use slipstream_bus::InputError;
use slipstream_bus::experiment::{Clock, OnDeath};
use slipstream_bus::message::robot_name;
use slipstream_bus::time::s_from_ns;
use slipstream_ipc::run_directory::{RunDirectory, RunLock, SHARED_MEMORY};
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_sim::run::process::PlantOutcome;

use super::child::{ChildProcess, Start};
use super::options::{LaunchError, Options};
use super::progress_line::ProgressLine;
use super::{preflight, report, signals};
use crate::recorder::trace_files::{self, save_trace};
use crate::resolve::Resolved;
use crate::role::Role;
use crate::run_files;
use crate::summary::{Process, ProcessReports, RunStatus, RunSummary};

/// Longest wait between two updates of the progress line.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Processes still alive this long after a stop are killed.
const STOP_TIMEOUT: Duration = Duration::from_millis(800);
/// Time that the recorder has to write the rest after the others have ended.
const WRITE_TIMEOUT: Duration = Duration::from_secs(30);
/// Largest number of restarts of one robot's agent.
const MAX_RESTARTS: u32 = 10;

fn system(step: &'static str) -> impl FnOnce(std::io::Error) -> LaunchError {
    move |error| LaunchError::System { step, error }
}

/// A run in progress. Dropping it kills every process and removes what they share.
struct Run<'a> {
    resolved: &'a Resolved,
    options: &'a Options,
    directory: RunDirectory,
    wake_page: WakePage,
    children: Vec<ChildProcess>,
    /// All processes that were ever started.
    processes: Vec<Process>,
    status: RunStatus,
    /// When a stop was requested before the planned end.
    stopped: Option<Instant>,
    /// When the last process but the recorder ended.
    drained: Option<Instant>,
    _lock: RunLock,
}

/// Runs an experiment as processes of its own.
///
/// # Errors
/// When the run cannot be started. Later failures are in the summary's status.
pub fn run(resolved: &Resolved, options: &Options) -> Result<RunSummary, LaunchError> {
    let settings = &resolved.experiment.settings;
    preflight::check(settings.robots.count)?;
    if let Some(out) = &options.out {
        check_writable(out)?;
    }
    let _tracing = match options.out {
        Some(_) => trace_files::begin(&resolved.experiment, "launcher")?,
        None => None,
    };
    let mut signals = signals::listen().map_err(system("listen for signals"))?;
    let begin = Instant::now();
    let mut run = Run::prepare(resolved, options)?;
    run.start().map_err(system("start the processes"))?;
    let progress = ProgressLine::new(options.live, settings);
    while run.children.iter().any(ChildProcess::is_running) {
        run.wait(&mut signals)
            .map_err(system("wait for the processes"))?;
        progress.draw(&run.wake_page);
    }
    progress.clear();
    let mut summary = run.summarise();
    summary.wall_s = begin.elapsed().as_secs_f64();
    Ok(summary)
}

impl<'a> Run<'a> {
    fn prepare(resolved: &'a Resolved, options: &'a Options) -> Result<Self, LaunchError> {
        let unwritable = |error: std::io::Error| {
            let remedy = "check its permissions and free space (slipstream clean)";
            InputError::new(SHARED_MEMORY, format!("cannot be written: {error}"), remedy)
        };
        let (directory, lock) = RunDirectory::create(rand::random()).map_err(unwritable)?;
        let files = run_files::write(&directory, &resolved.experiment, &resolved.to_toml());
        let robots = resolved.experiment.robots.len();
        let wake_page = files.and_then(|()| WakePage::create(&directory.wake_page(), robots));
        let wake_page = match wake_page {
            Ok(wake_page) => wake_page,
            Err(error) => {
                let _ = directory.remove();
                return Err(unwritable(error).into());
            }
        };
        Ok(Self {
            resolved,
            options,
            directory,
            wake_page,
            children: Vec::new(),
            processes: Vec::new(),
            status: RunStatus::Done,
            stopped: None,
            drained: None,
            _lock: lock,
        })
    }

    /// Starts the plant first: all others wait for its services.
    fn start(&mut self) -> std::io::Result<()> {
        self.spawn(Role::Plant, 0)?;
        if self.options.out.is_some() {
            self.spawn(Role::Recorder, 0)?;
        }
        for robot in 0..self.resolved.experiment.settings.robots.count {
            self.spawn(Role::Agent(robot), 0)?;
        }
        Ok(())
    }

    fn spawn(&mut self, role: Role, restarts: u32) -> std::io::Result<()> {
        let start = Start {
            options: self.options,
            directory: &self.directory,
            trace: self.resolved.experiment.settings.recording.trace,
        };
        let child = ChildProcess::spawn(start, role, restarts)?;
        self.processes.push(child.describe());
        self.children.push(child);
        Ok(())
    }

    /// Waits for an event, at most for [`POLL_INTERVAL`], and handles it.
    fn wait(&mut self, signals: &mut UnixStream) -> std::io::Result<()> {
        let ended = self.poll(signals)?;
        let mut buffer = [0; 16];
        if matches!(signals.read(&mut buffer), Ok(1..)) {
            if self.status == RunStatus::Interrupted {
                self.kill_all();
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
        let working = |child: &ChildProcess| child.role != Role::Recorder && child.is_running();
        if self.drained.is_none() && !self.children.iter().any(working) {
            self.drained = Some(Instant::now());
            save_trace(self.directory.folder(), "launcher");
            self.wake_page.advance(Stage::Drained);
        }
        self.kill_overdue();
        Ok(())
    }

    /// Kills processes that have not ended in time after a stop. The recorder gets twice the time.
    fn kill_overdue(&self) {
        let overdue =
            |since: Option<Instant>, timeout| since.is_some_and(|t| t.elapsed() > timeout);
        let timeout = if self.drained.is_some() {
            2 * STOP_TIMEOUT
        } else {
            STOP_TIMEOUT
        };
        if overdue(self.stopped, timeout) || overdue(self.drained, WRITE_TIMEOUT) {
            self.kill_all();
        }
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
        if role == Role::Recorder {
            self.wake_page.set_recorder_gone();
        }
        let time_s = s_from_ns(self.wake_page.progress().0);
        let Some(reason) = self.children[index].failure(&self.directory, time_s) else {
            return Ok(());
        };
        self.fail(reason);
        if role != Role::Recorder {
            let robot = role.robot().map(|robot| robot as usize);
            self.wake_page.count_death(robot);
        }
        let settings = &self.resolved.experiment.settings;
        let continues = settings.clock == Clock::Wall
            && settings.on_death != OnDeath::Stop
            && role != Role::Plant
            && self.wake_page.stage() == Stage::Running
            && self.stopped.is_none();
        if !continues {
            self.stop();
            if role == Role::Plant {
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

    /// Sets the status to failed; the first reason is kept.
    fn fail(&mut self, reason: String) {
        if self.status == RunStatus::Done {
            self.status = RunStatus::Failed(reason);
        }
    }

    fn stop(&mut self) {
        self.stopped.get_or_insert(Instant::now());
        self.wake_page.stop();
    }

    fn kill_all(&self) {
        self.children.iter().for_each(ChildProcess::kill);
    }

    /// Assembles the summary from the final reports of the processes.
    fn summarise(&mut self) -> RunSummary {
        let robots = self.resolved.experiment.settings.robots.count;
        let plant: Option<PlantOutcome> = report::read(&self.directory, &Role::Plant.name());
        let agents: Vec<Option<AgentOutcome>> = (0..robots)
            .map(|robot| report::read(&self.directory, &robot_name(robot)))
            .collect();
        let reports = ProcessReports {
            plant: plant.as_ref().map(|plant| plant.report.clone()),
            agents: agents
                .iter()
                .map(|agent| agent.as_ref().map(|a| a.report))
                .collect(),
        };
        let mut summary = RunSummary::new(&self.resolved.experiment, &reports);
        summary.processes = std::mem::take(&mut self.processes);
        summary.recording = self.options.out.clone().filter(|out| out.exists());
        summary.status = self.status.clone();
        if plant.is_none() {
            summary.duration_s = s_from_ns(self.wake_page.progress().0);
        }
        summary.add_timing(plant.as_ref(), &agents);
        summary
    }
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        self.kill_all();
        for child in &mut self.children {
            let _ = child.wait();
        }
        if let Err(error) = self.directory.remove() {
            let folder = self.directory.folder().display();
            // Standard error may be closed.
            let _ = writeln!(
                std::io::stderr(),
                "{folder}: {error}; remove it with slipstream clean"
            );
        }
    }
}

/// Checks that the recording can be written, before anything is started.
fn check_writable(out: &Path) -> Result<(), InputError> {
    let opened = std::fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(out);
    opened.map(drop).map_err(|error| {
        let place = format!("--out {}", out.display());
        InputError::new(
            place,
            format!("cannot be written: {error}"),
            "give another file",
        )
    })
}
