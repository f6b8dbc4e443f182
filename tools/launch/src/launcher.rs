//! A run of real processes: started, watched, stopped, cleaned up after.

use std::io::{Read, Write as _};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process, pidfd_open};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use slipstream_agents::process::AgentOutcome;
use slipstream_bus::experiment::{Clock, OnDeath};
use slipstream_bus::message::robot_name;
use slipstream_bus::time::s_from_ns;
use slipstream_ipc::clock::RealTime;
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::run_directory::{RunDirectory, RunLock};
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_sim::run::process::PlantOutcome;

use crate::live::Live;
use crate::outcome::{DeadlineOutcome, Outcome, Parts, Process, Verdict};
use crate::recorder::RecorderOutcome;
use crate::resolve::Resolved;
use crate::roles::read_report;
use crate::tape::{self, leave_tape};
use crate::{place_files, preflight};
use slipstream_bus::InputError;

/// How often the live line is drawn.
const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Who has not ended so long after the run was stopped is ended.
const GRACE: Duration = Duration::from_millis(800);
/// How long the recorder may take to write what is left after an orderly end.
const WRITING: Duration = Duration::from_secs(30);
/// How often a dead agent is started again.
const RESTARTS: u32 = 10;

/// How a run is to be started.
#[derive(Debug, Clone)]
pub struct Options {
    /// The program that plays the roles.
    pub program: PathBuf,
    /// The recording, if there is to be one.
    pub out: Option<PathBuf>,
    /// Draw a live line.
    pub live: bool,
}

/// Why a run did not come to an outcome.
#[derive(Debug, thiserror::Error)]
pub enum LaunchError {
    /// The input or the system will not do.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The system failed.
    #[error("failed to {step}: {error}")]
    System {
        /// What was being done.
        step: &'static str,
        /// What the system said.
        error: std::io::Error,
    },
}

fn system(step: &'static str) -> impl FnOnce(std::io::Error) -> LaunchError {
    move |error| LaunchError::System { step, error }
}

/// One process of the run.
#[derive(Debug)]
struct Member {
    role: &'static str,
    /// An agent's robot, counted from 0.
    robot: Option<u32>,
    child: Child,
    pidfd: OwnedFd,
    status: Option<ExitStatus>,
    restarts: u32,
}

/// A run under way. Dropping it ends every process and removes what it shares.
struct Run<'a> {
    resolved: &'a Resolved,
    options: &'a Options,
    place: RunDirectory,
    wake_page: WakePage,
    members: Vec<Member>,
    processes: Vec<Process>,
    verdict: Verdict,
    /// Since when the run is being stopped before its time.
    stopping: Option<Instant>,
    /// Since when everybody but the recorder is gone.
    drained: Option<Instant>,
    _alive: RunLock,
}

/// Runs an experiment as processes of its own.
///
/// # Errors
/// When the system does not let it be started. What happens later is in the outcome's verdict.
pub fn run(resolved: &Resolved, options: &Options) -> Result<Outcome, LaunchError> {
    let settings = &resolved.experiment.settings;
    preflight::check(settings.robots.count)?;
    if let Some(out) = &options.out {
        writable(out)?;
    }
    let _tracing = match options.out {
        Some(_) => tape::begin(&resolved.experiment, "launcher")?,
        None => None,
    };
    let mut signals = listen_to_signals().map_err(system("listen to signals"))?;
    let begin = Instant::now();
    let mut run = Run::prepare(resolved, options)?;
    run.start().map_err(system("start the processes"))?;
    let live = Live::new(options.live, settings);
    while run.members.iter().any(|member| member.status.is_none()) {
        run.wait(&mut signals)
            .map_err(system("wait for the processes"))?;
        live.draw(&run.wake_page);
    }
    live.clear();
    let mut outcome = run.collect();
    outcome.wall_s = begin.elapsed().as_secs_f64();
    Ok(outcome)
}

impl<'a> Run<'a> {
    fn prepare(resolved: &'a Resolved, options: &'a Options) -> Result<Self, LaunchError> {
        let full = |error: std::io::Error| {
            let place = slipstream_ipc::run_directory::SHARED_MEMORY;
            let remedy = "check its rights and free space (slipstream clean)";
            InputError::new(place, format!("cannot be written: {error}"), remedy)
        };
        let (place, alive) = RunDirectory::create(rand::random()).map_err(full)?;
        let files = place_files::write(&place, &resolved.experiment, &resolved.to_toml());
        let robots = resolved.experiment.robots.len();
        let wake_page = files.and_then(|()| WakePage::create(&place.wake_page(), robots));
        let wake_page = match wake_page {
            Ok(wake_page) => wake_page,
            Err(error) => {
                let _ = place.remove();
                return Err(full(error).into());
            }
        };
        Ok(Self {
            resolved,
            options,
            place,
            wake_page,
            members: Vec::new(),
            processes: Vec::new(),
            verdict: Verdict::Done,
            stopping: None,
            drained: None,
            _alive: alive,
        })
    }

    /// Starts the plant first, since all others wait for its services.
    fn start(&mut self) -> std::io::Result<()> {
        self.spawn("plant", None, false)?;
        if self.options.out.is_some() {
            self.spawn("recorder", None, false)?;
        }
        for robot in 0..self.resolved.experiment.settings.robots.count {
            self.spawn("agent", Some(robot), false)?;
        }
        Ok(())
    }

    fn spawn(
        &mut self,
        role: &'static str,
        robot: Option<u32>,
        rejoins: bool,
    ) -> std::io::Result<()> {
        let mut command = Command::new(&self.options.program);
        command.arg(role).arg("--run").arg(self.place.folder());
        if let Some(robot) = robot {
            command.arg("--robot").arg(robot.to_string());
        }
        if rejoins {
            command.arg("--rejoins");
        }
        if let Some(out) = &self.options.out {
            command.arg("--recording");
            if self.resolved.experiment.settings.recording.trace {
                command.arg("--trace");
            }
            if role == "recorder" {
                command.arg("--out").arg(out);
            }
        }
        // A group of its own: Ctrl-C is the launcher's business.
        command
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        let child = command.spawn()?;
        let pidfd = pidfd_open(Pid::from_child(&child), PidfdFlags::empty())?;
        tracing::info!(name: "started", role, robot, pid = child.id());
        self.processes.push(Process {
            role,
            robot: robot.map(robot_name),
            pid: child.id(),
        });
        self.members.push(Member {
            role,
            robot,
            child,
            pidfd,
            status: None,
            restarts: 0,
        });
        Ok(())
    }

    /// Waits until something happens, at most for a glance, and does what it asks for.
    fn wait(&mut self, signals: &mut UnixStream) -> std::io::Result<()> {
        let ended = self.poll(signals)?;
        let mut buffer = [0; 16];
        if matches!(signals.read(&mut buffer), Ok(1..)) {
            if self.verdict == Verdict::Interrupted {
                self.kill_all();
            }
            self.verdict = Verdict::Interrupted;
            self.stop();
        }
        for index in ended {
            let status = self.members[index].child.wait()?;
            self.members[index].status = Some(status);
            trace::set_virtual_time(self.wake_page.progress().0);
            let member = &self.members[index];
            tracing::info!(name: "ended", role = member.role, robot = member.robot, status = %status);
            self.after_end(index, status)?;
        }
        let working = |member: &Member| member.role != "recorder" && member.status.is_none();
        if self.drained.is_none() && !self.members.iter().any(working) {
            self.drained = Some(Instant::now());
            leave_tape(self.place.folder(), "launcher");
            self.wake_page.advance(Stage::Drained);
        }
        let overdue = |since: Option<Instant>, grace| since.is_some_and(|t| t.elapsed() > grace);
        let grace = if self.drained.is_some() {
            2 * GRACE
        } else {
            GRACE
        };
        if overdue(self.stopping, grace) || overdue(self.drained, WRITING) {
            self.kill_all();
        }
        Ok(())
    }

    /// The members that have ended since the last call.
    fn poll(&self, signals: &UnixStream) -> std::io::Result<Vec<usize>> {
        let running: Vec<usize> = (0..self.members.len())
            .filter(|&i| self.members[i].status.is_none())
            .collect();
        let pidfds = running.iter().map(|&i| self.members[i].pidfd.as_fd());
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

    /// A process has ended: in its time, or not.
    fn after_end(&mut self, index: usize, status: ExitStatus) -> std::io::Result<()> {
        let member = &self.members[index];
        let (role, robot) = (member.role, member.robot);
        if role == "recorder" {
            self.wake_page.set_recorder_gone();
        }
        let Some(reason) = self.why_dead(index, status) else {
            return Ok(());
        };
        self.fail(reason);
        if role != "recorder" {
            self.wake_page
                .count_death(robot.map(|robot| robot as usize));
        }
        let settings = &self.resolved.experiment.settings;
        let goes_on = settings.clock == Clock::Wall
            && settings.on_death != OnDeath::Stop
            && role != "plant"
            && self.wake_page.stage() == Stage::Running
            && self.stopping.is_none();
        if !goes_on {
            self.stop();
            if role == "plant" {
                self.wake_page.advance(Stage::Over);
            }
            return Ok(());
        }
        let restarts = self.members[index].restarts;
        if role == "agent" && settings.on_death == OnDeath::Restart && restarts < RESTARTS {
            self.spawn(role, robot, true)?;
            if let Some(again) = self.members.last_mut() {
                again.restarts = restarts + 1;
            }
        }
        Ok(())
    }

    /// Why a process that ended counts as dead; `None` when it ended in order.
    fn why_dead(&self, index: usize, status: ExitStatus) -> Option<String> {
        let member = &self.members[index];
        let (name, pid) = (member.name(), member.child.id());
        let when = s_from_ns(self.wake_page.progress().0);
        if let Some(signal) = status.signal() {
            return Some(format!(
                "{name} (pid {pid}) died of signal {signal} at {when:.3} s"
            ));
        }
        if !status.success() {
            return Some(format!("{name} (pid {pid}) failed at {when:.3} s"));
        }
        let place = &self.place;
        let ended = match member.role {
            "plant" => read_report(place, "plant").map(|plant: PlantOutcome| plant.ended),
            "agent" => read_report(place, &name).map(|agent: AgentOutcome| agent.ended),
            _ => read_report(place, "recorder").map(|recorder: RecorderOutcome| {
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

    /// Keeps the first reason.
    fn fail(&mut self, reason: String) {
        if self.verdict == Verdict::Done {
            self.verdict = Verdict::Failed(reason);
        }
    }

    fn stop(&mut self) {
        self.stopping.get_or_insert(Instant::now());
        self.wake_page.stop();
    }

    fn kill_all(&mut self) {
        for member in self.members.iter().filter(|member| member.status.is_none()) {
            // It may have ended just now; that is as good.
            let _ = kill_process(Pid::from_child(&member.child), Signal::KILL);
        }
    }

    /// What all had to say.
    fn collect(&mut self) -> Outcome {
        let robots = self.resolved.experiment.settings.robots.count;
        let plant: Option<PlantOutcome> = read_report(&self.place, "plant");
        let agents: Vec<Option<AgentOutcome>> = (0..robots)
            .map(|i| read_report(&self.place, &robot_name(i)))
            .collect();
        let parts = Parts {
            plant: plant.as_ref().map(|plant| plant.report.clone()),
            agents: agents
                .iter()
                .map(|agent| agent.as_ref().map(|a| a.report))
                .collect(),
        };
        let mut outcome = Outcome::new(&self.resolved.experiment, &parts);
        outcome.processes = std::mem::take(&mut self.processes);
        outcome.recording = self.options.out.clone().filter(|out| out.exists());
        outcome.verdict = self.verdict.clone();
        let lost = agents
            .iter()
            .flatten()
            .map(|agent| agent.lost_records)
            .sum::<u64>();
        outcome.lost_records = lost + plant.as_ref().map_or(0, |plant| plant.lost_records);
        if let Some(plant) = &plant {
            outcome.loop_s = plant.loop_s;
            outcome.start_up_s = plant.start_up_s;
            let all = agents.iter().flatten().map(|agent| agent.real_time);
            let least = all.fold(plant.real_time, RealTime::both);
            outcome.real_time = plant.deadlines.map(|_| least);
        } else {
            outcome.duration_s = s_from_ns(self.wake_page.progress().0);
        }
        let step = plant.as_ref().and_then(|plant| plant.deadlines);
        outcome
            .deadlines
            .extend(step.map(|d| DeadlineOutcome::new("plant", "step", &d)));
        for (robot, agent) in (0..).zip(&agents) {
            if let Some([outer, inner]) = agent.as_ref().and_then(|agent| agent.deadlines) {
                let name = robot_name(robot);
                outcome
                    .deadlines
                    .push(DeadlineOutcome::new(&name, "outer", &outer));
                outcome
                    .deadlines
                    .push(DeadlineOutcome::new(&name, "inner", &inner));
            }
        }
        outcome
    }
}

impl Member {
    fn name(&self) -> String {
        self.robot.map_or_else(|| self.role.to_owned(), robot_name)
    }
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        self.kill_all();
        for member in &mut self.members {
            let _ = member.child.wait();
        }
        if let Err(error) = self.place.remove() {
            let folder = self.place.folder().display();
            // Where standard error is closed there is nobody to tell.
            let _ = writeln!(std::io::stderr(), "{folder}: {error}; slipstream clean");
        }
    }
}

/// A stream from which each SIGINT, SIGTERM or SIGHUP can be read as a byte.
fn listen_to_signals() -> std::io::Result<UnixStream> {
    let (read, write) = UnixStream::pair()?;
    read.set_nonblocking(true)?;
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::low_level::pipe::register(signal, write.try_clone()?)?;
    }
    Ok(read)
}

/// Whether the recording can be written there; asked before anything is started.
fn writable(out: &Path) -> Result<(), InputError> {
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
