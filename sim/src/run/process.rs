//! The process of the plant: the world tied to the bus and the clock.

use std::path::Path;
use std::rc::Rc;

use slipstream_bus::Experiment;
use slipstream_bus::message::{Encoders, TorqueCommand};
use slipstream_bus::record::Recorder;
use slipstream_bus::time::ns_from_s;
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Deadlines, Monotonic, RealTime, WallClock};
use slipstream_ipc::endpoints::PlantEndpoint;
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::{PLANT_CHUNK, Services};
use slipstream_ipc::wake_page::{Stage, WakePage};

use super::lockstep::{Progress, applied, command, lockstep, read_encoders, record_sensors};
use super::observer::{Observer, PlantReport};
use super::world;
use crate::{Command, World};

/// Priority of the plant's loop among real-time threads.
const PRIORITY: u8 = 30;
/// From everybody being connected to time 0 on the wall clock (ns).
const LEAD_NS: i64 = 20_000_000;

/// What the plant's process has to say at its end.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlantOutcome {
    /// The truth about the run.
    pub report: PlantReport,
    /// How it ended.
    pub ended: ProcessStatus,
    /// Deadlines of the step; on the wall clock.
    pub deadlines: Option<Deadlines>,
    /// What the system permitted; on the wall clock.
    pub real_time: RealTime,
    /// Records that did not reach the recorder.
    pub lost_records: u64,
    /// From the process's begin until everybody was connected (s), and from there to the end (s).
    pub start_up_s: f64,
    /// The loop alone (s).
    pub loop_s: f64,
}

/// Runs the plant of the run in `folder` to its end.
///
/// # Errors
/// When it cannot join the run.
pub fn run(folder: &Path, recording: bool) -> Result<PlantOutcome, BusError> {
    let begin = std::time::Instant::now();
    let joined = JoinedRun::new(folder)?;
    let experiment = &joined.experiment;
    let mut world = world(experiment).map_err(|error| BusError::Failed {
        what: "robot".to_owned(),
        reason: error.to_string(),
    })?;
    let services = Services::join(&joined.directory, experiment, "plant")?;
    let kept = services.create_all()?;
    joined.wake_page.advance(Stage::Services);
    let wake_page = Rc::clone(&joined.wake_page);
    let mut end = PlantEndpoint::new(&services, Rc::clone(&wake_page), joined.parent)?;
    let mut records = RecordSender::new(&services, wake_page, 0, PLANT_CHUNK, recording)?;
    end.await_ready(experiment.settings.robots.count + u32::from(recording))?;
    drop(kept);
    let start_up_s = begin.elapsed().as_secs_f64();

    let begin = std::time::Instant::now();
    let mut observer = Observer::new(experiment, true);
    let mut deadlines = Deadlines::default();
    let (ended, real_time) = if services.lockstep() {
        joined.wake_page.advance(Stage::Running);
        let mut teller = Teller(&joined.wake_page);
        let ended = lockstep(
            experiment,
            &mut world,
            &mut observer,
            &mut end,
            &mut records,
            &mut teller,
        );
        (ended, RealTime::default())
    } else {
        let real_time = RealTime::request(PRIORITY);
        let mut run = Wall {
            end: &end,
            records: &mut records,
            wake_page: &joined.wake_page,
        };
        (
            run.run(experiment, &mut world, &mut observer, &mut deadlines),
            real_time,
        )
    };
    joined.wake_page.advance(Stage::Over);
    records.flush();
    Ok(PlantOutcome {
        report: observer.finish(&world),
        ended: ended.into(),
        deadlines: (!services.lockstep()).then_some(deadlines),
        real_time,
        lost_records: records.lost(),
        start_up_s,
        loop_s: begin.elapsed().as_secs_f64(),
    })
}

/// Tells how far the run has come.
struct Teller<'a>(&'a WakePage);

impl Progress for Teller<'_> {
    fn at(&mut self, now_ns: i64, world: &World, observer: &Observer) {
        let (speed_m_s, spacing_error_m) = observer.glance(world);
        self.0.publish_progress(now_ns, speed_m_s, spacing_error_m);
    }
}

/// The plant on the wall clock: a step at each deadline, with the newest torques.
struct Wall<'a> {
    end: &'a PlantEndpoint,
    records: &'a mut RecordSender,
    wake_page: &'a WakePage,
}

impl Wall<'_> {
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
        let mut actuators = Actuators::new(experiment.robots.len(), timeout_ns);
        let mut encoders = vec![Encoders::default(); experiment.robots.len()];
        read_encoders(world, 0, &mut encoders);
        self.end.publish(0, &encoders)?;
        let start = Monotonic::now().plus_ns(LEAD_NS);
        let clock = WallClock::new(start);
        self.wake_page.set_start_ns(start.to_shared());
        self.wake_page.advance(Stage::Running);
        while world.time_ns() < end_ns {
            // The step from `now_ns` on is taken when its end is due.
            let now_ns = world.time_ns();
            let next_ns = (now_ns + step_ns).min(end_ns);
            clock.sleep_until(next_ns);
            let began_ns = clock.now_ns();
            self.end.check_running()?;
            actuators.listen(self.end, now_ns, clock, self.records)?;
            world.step(next_ns - now_ns, &actuators.commands);
            read_encoders(world, next_ns, &mut encoders);
            self.end.publish(next_ns, &encoders)?;
            observer.step(world, next_ns - now_ns, self.records);
            record_sensors(world, encoders.len(), self.records);
            Teller(self.wake_page).at(next_ns, world, observer);
            self.records.flush_if_due();
            deadlines.count(next_ns, began_ns, clock.now_ns(), step_ns);
        }
        Ok(())
    }
}

/// The drives of all robots: the newest torque each, none when it is too old.
struct Actuators {
    newest: Vec<TorqueCommand>,
    heard_ns: Vec<i64>,
    commands: Vec<Command>,
    timeout_ns: i64,
}

impl Actuators {
    fn new(robots: usize, timeout_ns: i64) -> Self {
        let newest = vec![TorqueCommand::default(); robots];
        let commands = newest.iter().map(command).collect();
        Self {
            newest,
            heard_ns: vec![0; robots],
            commands,
            timeout_ns,
        }
    }

    fn listen(
        &mut self,
        end: &PlantEndpoint,
        now_ns: i64,
        clock: WallClock,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        end.drain_commands(|torque| {
            let robot = torque.robot as usize;
            self.heard_ns[robot] = now_ns;
            if torque.tick_ns != self.newest[robot].tick_ns || now_ns == 0 {
                recorder.record(&applied(now_ns, clock.now_ns(), torque));
            }
            self.newest[robot] = *torque;
            self.commands[robot] = command(torque);
        })?;
        for (heard_ns, torque) in self.heard_ns.iter().zip(&mut self.commands) {
            if now_ns - heard_ns > self.timeout_ns {
                *torque = Command::rest();
            }
        }
        Ok(())
    }
}
