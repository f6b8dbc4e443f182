//! Process of the plant: connects the world to shared memory, clock and recorder.

use std::path::Path;
use std::time::Duration;

use slipstream_bus::Experiment;
use slipstream_bus::experiment::Drive;
use slipstream_bus::message::{DriveCommand, Encoders};
use slipstream_bus::record::Recorder;
use slipstream_bus::time::ns_from_s;
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Deadlines, Monotonic, RealTime, WallClock};
use slipstream_ipc::endpoints::PlantEndpoint;
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::presence::{Parent, Presence};
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::{PLANT_CHUNK, Services};
use slipstream_ipc::wake_page::{Member, Stage};

use super::lockstep::{
    Progress, applied, changes, command, lockstep, no_command, read_encoders, record_sensors,
    require_finite,
};
use super::observer::{Observer, PlantReport};
use super::world;
use crate::{Command, World};

/// Real-time priority of the plant's loop.
const PRIORITY: u8 = 30;
/// Timeout for the answers of a round, beside that for an answer of another host. The launcher ends an agent that hangs
/// before.
const ANSWER_TIMEOUT: Duration = Duration::from_secs(10);
/// Time between all processes being connected and time 0 of the run, on the wall clock (ns).
const START_DELAY_NS: i64 = 20_000_000;

/// Result of the plant's process.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlantOutcome {
    /// Ground truth of the run.
    pub report: PlantReport,
    /// How the process ended.
    pub ended: ProcessStatus,
    /// Met and missed deadlines of the step; `None` in lockstep.
    pub deadlines: Option<Deadlines>,
    /// Real-time scheduling that the system granted; the default in lockstep.
    pub real_time: RealTime,
    /// Number of records that did not reach the recorder.
    pub lost_records: u64,
    /// Time from the start of the process until all processes were connected (s).
    pub start_up_s: f64,
    /// Time of the loop from then to the end (s).
    pub loop_s: f64,
}

/// Runs the plant of the run in `folder` to its end. `recording`: whether there is a recorder.
///
/// # Errors
/// When the process cannot join the run or a robot model is invalid. Errors after that are in
/// [`PlantOutcome::ended`].
pub fn run(folder: &Path, launcher: Parent, recording: bool) -> Result<PlantOutcome, BusError> {
    let begin = std::time::Instant::now();
    let joined = JoinedRun::new(folder, Member::Plant, launcher)?;
    let experiment = &joined.experiment;
    let mut world = world(experiment).map_err(|error| BusError::Failed {
        what: "robot".to_owned(),
        reason: error.to_string(),
    })?;
    let services = Services::join(&joined.directory, experiment, "plant")?;
    let kept = services.create_all()?;
    joined.wake_page().advance(Stage::Services);
    let mut end = PlantEndpoint::new(&services, joined.presence.clone())?;
    let host_timeout = Duration::from_secs_f64(experiment.settings.host_timeout_s);
    end.set_answer_timeout(ANSWER_TIMEOUT + host_timeout);
    let mut records = RecordSender::new(
        &services,
        joined.presence.clone(),
        0,
        PLANT_CHUNK,
        recording,
    )?;
    end.await_ready(experiment.settings.robots.count + u32::from(recording))?;
    drop(kept);
    let start_up_s = begin.elapsed().as_secs_f64();

    let begin = std::time::Instant::now();
    let mut observer = Observer::new(experiment, true);
    let mut deadlines = Deadlines::default();
    let (ended, real_time) = if services.lockstep() {
        joined.wake_page().advance(Stage::Running);
        let mut publisher = ProgressPublisher(&joined.presence);
        let ended = lockstep(
            experiment,
            &mut world,
            &mut observer,
            &mut end,
            &mut records,
            &mut publisher,
        );
        (ended, RealTime::default())
    } else {
        let real_time = RealTime::request(PRIORITY);
        let mut run = WallClockLoop {
            end: &end,
            records: &mut records,
            presence: &joined.presence,
        };
        (
            run.run(experiment, &mut world, &mut observer, &mut deadlines),
            real_time,
        )
    };
    joined.wake_page().advance(Stage::Over);
    let loop_s = begin.elapsed().as_secs_f64();
    records.finish();
    Ok(PlantOutcome {
        report: observer.finish(&world),
        ended: ended.into(),
        deadlines: (!services.lockstep()).then_some(deadlines),
        real_time,
        lost_records: records.lost(),
        start_up_s,
        loop_s,
    })
}

/// Publishes the progress of the run on the wake-up page.
struct ProgressPublisher<'a>(&'a Presence);

impl Progress for ProgressPublisher<'_> {
    fn at(&mut self, now_ns: i64, world: &World, observer: &Observer) {
        let (speed_m_s, spacing_error_m) = observer.progress(world);
        let wake_page = self.0.wake_page();
        wake_page.publish_progress(now_ns, speed_m_s, spacing_error_m);
    }

    fn stepped(&mut self) {
        self.0.show();
    }
}

/// The plant's loop on the wall clock: one step at each deadline, with the newest commands.
struct WallClockLoop<'a> {
    end: &'a PlantEndpoint,
    records: &'a mut RecordSender,
    presence: &'a Presence,
}

impl WallClockLoop<'_> {
    fn run(
        &mut self,
        experiment: &Experiment,
        world: &mut World,
        observer: &mut Observer,
        deadlines: &mut Deadlines,
    ) -> Result<(), BusError> {
        let settings = &experiment.settings;
        let step_ns = ns_from_s(settings.plant.step_s);
        let end_ns = ns_from_s(settings.duration_s);
        let timeout_ns = ns_from_s(settings.plant.command_timeout_s);
        let mut changes = changes(experiment)?;
        let drive = settings.control.drive;
        let mut actuators = Actuators::new(experiment.robots.len(), drive, timeout_ns);
        let mut encoders = vec![Encoders::default(); experiment.robots.len()];
        read_encoders(world, 0, &mut encoders);
        self.end.publish(0, &encoders)?;
        let start = Monotonic::now().plus_ns(START_DELAY_NS);
        let clock = WallClock::new(start);
        let wake_page = self.presence.wake_page();
        wake_page.set_start_ns(start.to_shared());
        wake_page.advance(Stage::Running);
        while world.time_ns() < end_ns {
            // The step that starts at `now_ns` is computed when its end is due.
            let now_ns = world.time_ns();
            let next_ns = (now_ns + step_ns).min(end_ns);
            self.presence.sleep_until(clock, next_ns);
            let began_ns = clock.now_ns();
            self.end.check_running()?;
            actuators.receive(self.end, now_ns, clock, self.records)?;
            changes.apply(world);
            world.step(next_ns - now_ns, &actuators.commands);
            read_encoders(world, next_ns, &mut encoders);
            self.end.publish(next_ns, &encoders)?;
            observer.step(world, next_ns - now_ns, self.records);
            record_sensors(world, encoders.len(), self.records);
            ProgressPublisher(self.presence).at(next_ns, world, observer);
            require_finite(experiment, world)?;
            self.records.flush_if_due();
            deadlines.count(next_ns, began_ns, clock.now_ns(), step_ns);
            self.presence
                .publish_deadlines(&[deadlines.to_shared(next_ns)]);
        }
        Ok(())
    }
}

/// Actuators of all robots: the newest command of each, none once it is older than the timeout.
struct Actuators {
    newest: Vec<DriveCommand>,
    /// Time at which each robot's newest command arrived (ns).
    received_ns: Vec<i64>,
    commands: Vec<Command>,
    none: Command,
    timeout_ns: i64,
}

impl Actuators {
    fn new(robots: usize, drive: Drive, timeout_ns: i64) -> Self {
        let none = no_command(drive);
        Self {
            newest: vec![DriveCommand::default(); robots],
            received_ns: vec![0; robots],
            commands: vec![none; robots],
            none,
            timeout_ns,
        }
    }

    /// Takes over the commands that have arrived, records new ones, and drops those that are too
    /// old.
    fn receive(
        &mut self,
        end: &PlantEndpoint,
        now_ns: i64,
        clock: WallClock,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        end.drain_commands(|told| {
            let robot = told.robot as usize;
            self.received_ns[robot] = now_ns;
            if told.tick_ns != self.newest[robot].tick_ns || now_ns == 0 {
                recorder.record(&applied(now_ns, clock.now_ns(), told));
            }
            self.newest[robot] = *told;
            self.commands[robot] = command(&told.actuation);
        })?;
        for (received_ns, command) in self.received_ns.iter().zip(&mut self.commands) {
            if now_ns - received_ns > self.timeout_ns {
                *command = self.none;
            }
        }
        Ok(())
    }
}
