//! Process of the robots: connects a [`Fleet`] to the agents' shared memory and to topics. To the agents it is the plant.

mod spacing;

use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use slipstream_bag::ros::wire;
use slipstream_bus::Experiment;
use slipstream_bus::experiment::OnDeath;
use slipstream_bus::message::{Actuation, Encoders};
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Monotonic, RealTime, WallClock};
use slipstream_ipc::endpoints::PlantEndpoint;
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::presence::{Parent, Presence};
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::{PLANT_CHUNK, Services};
use slipstream_ipc::wake_page::{Member, Stage};

use self::spacing::Spacings;
use crate::fleet::{Fleet, RobotReport, Standing};
use crate::lab::{CommandMessage, Content, Lab};
use crate::system_clock::system_ns;
use crate::topics::{self, Topics};

/// Real-time priority: that of the plant.
const PRIORITY: u8 = 30;
/// Time within which every robot has to be heard.
const HEARD_WITHIN: Duration = Duration::from_secs(10);
/// Time between all robots being heard and time 0 of the run (ns).
const START_DELAY_NS: i64 = 100_000_000;
/// Longest wait for a message before commands and silences are looked at.
const LOOK_INTERVAL: Duration = Duration::from_micros(250);
/// How long robots are told to stand at the end of a run.
const LEAVE_FOR: Duration = Duration::from_millis(300);

/// Result of the process of the robots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotsOutcome {
    /// The robots, from front to rear.
    pub robots: Vec<RobotReport>,
    /// Largest spacing error of each by its poses (m); `None` for the front robot and without poses.
    pub max_spacing_error_m: Vec<Option<f64>>,
    /// Time of the run at its end (s).
    pub duration_s: f64,
    /// How the process ended.
    pub ended: ProcessStatus,
    /// Real-time scheduling that the system granted.
    pub real_time: RealTime,
    /// Number of records that did not reach the recorder.
    pub lost_records: u64,
    /// Time until all robots were heard (s).
    pub start_up_s: f64,
    /// Time of the loop from then to the end (s).
    pub loop_s: f64,
}

/// Runs the robots of `lab` in the run in `folder` to its end. `recording`: whether there is a recorder; `notice`: says
/// what happens.
///
/// # Errors
/// The process cannot join the run, or the network cannot be used. Errors after that are in [`RobotsOutcome::ended`].
pub fn run(
    folder: &Path,
    launcher: Parent,
    recording: bool,
    lab: &Lab,
    notice: &dyn Fn(&str),
) -> Result<RobotsOutcome, BusError> {
    let open = || topics::open(&Fleet::opening(lab));
    run_over(folder, launcher, recording, lab, notice, open)
}

/// As [`run`], over the topics that `open` opens.
///
/// # Errors
/// As [`run`].
pub fn run_over(
    folder: &Path,
    launcher: Parent,
    recording: bool,
    lab: &Lab,
    notice: &dyn Fn(&str),
    open: impl FnOnce() -> Result<Box<dyn Topics>, BusError>,
) -> Result<RobotsOutcome, BusError> {
    let begin = Instant::now();
    let joined = JoinedRun::new(folder, Member::Plant, launcher)?;
    let experiment = &joined.experiment;
    let services = Services::join(&joined.directory, experiment, "robots")?;
    let kept = services.create_all()?;
    joined.wake_page().advance(Stage::Services);
    let presence = joined.presence.clone();
    let end = PlantEndpoint::new(&services, presence.clone())?;
    let records = RecordSender::new(&services, presence, 0, PLANT_CHUNK, recording)?;
    let mut robots = Robots {
        topics: open()?,
        fleet: Fleet::new(experiment, lab),
        presence: &joined.presence,
        experiment,
        lab,
        notice,
        end,
        records,
        clock: WallClock::new(Monotonic::now()),
        spacing: Spacings::new(experiment),
    };
    robots
        .end
        .await_ready(experiment.settings.robots.count + u32::from(recording))?;
    drop(kept);
    robots.await_robots()?;
    let start_up_s = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let real_time = RealTime::request(PRIORITY);
    let ended = robots.drive();
    robots.leave();
    joined.wake_page().advance(Stage::Over);
    let loop_s = begin.elapsed().as_secs_f64();
    robots.records.finish();
    Ok(RobotsOutcome {
        robots: robots.fleet.reports(),
        max_spacing_error_m: robots.spacing.largest_m.clone(),
        duration_s: s_from_ns(robots.clock.now_ns()).min(experiment.settings.duration_s),
        ended: ended.into(),
        real_time,
        lost_records: robots.records.lost(),
        start_up_s,
        loop_s,
    })
}

struct Robots<'a> {
    topics: Box<dyn Topics>,
    fleet: Fleet,
    presence: &'a Presence,
    experiment: &'a Experiment,
    lab: &'a Lab,
    notice: &'a dyn Fn(&str),
    end: PlantEndpoint,
    records: RecordSender,
    clock: WallClock,
    spacing: Spacings,
}

impl Robots<'_> {
    /// Waits until every robot is heard. Nothing is told to them.
    fn await_robots(&mut self) -> Result<(), BusError> {
        let begin = Instant::now();
        while !self.fleet.unheard().is_empty() {
            self.end.check_running()?;
            self.hear(LOOK_INTERVAL);
            if begin.elapsed() > HEARD_WITHIN {
                return Err(self.not_heard());
            }
        }
        Ok(())
    }

    /// Takes the messages that come within `timeout`. Returns whether wheels were heard.
    fn hear(&mut self, timeout: Duration) -> bool {
        let (mut timeout, mut wheels) = (timeout, false);
        while let Some(heard) = self.topics.receive(timeout) {
            timeout = Duration::ZERO;
            let arrived_ns = self.clock.ns_at(heard.arrived);
            let records = &mut self.records;
            let measured = self
                .fleet
                .hear(heard.place, &heard.payload, arrived_ns, records);
            let Some(measured) = measured else {
                continue;
            };
            wheels |= measured.content == Content::Wheels;
            if measured.measured_ns >= 0 {
                let (robot, measured_ns) = (measured.robot as u64, measured.measured_ns);
                let of = measured.content.name();
                tracing::debug!(name: "heard", t_ns = arrived_ns, robot, of, measured_ns);
            }
        }
        wheels
    }

    /// The error that names what was not heard.
    fn not_heard(&self) -> BusError {
        let unheard = self.fleet.unheard();
        let topic = |&(robot, content): &(usize, Content)| {
            let robot = self.lab.robots.get(robot)?;
            Some(format!("/{}", content.topic(robot)?))
        };
        let topics: Vec<String> = unheard.iter().filter_map(topic).collect();
        let unread = self.fleet.reports().into_iter().find_map(|own| own.problem);
        let seconds = HEARD_WITHIN.as_secs();
        let reason = match unread {
            Some(problem) => problem,
            None => format!(
                "nothing came from {} for {seconds} s; are bridge and robot on, and are the topics' names right? \
                 Nothing was told to any robot",
                topics.join(", ")
            ),
        };
        BusError::Failed {
            what: self.lab.path.display().to_string(),
            reason,
        }
    }

    /// Drives until the end of the run.
    fn drive(&mut self) -> Result<(), BusError> {
        let end_ns = ns_from_s(self.experiment.settings.duration_s);
        let later_ns = self.clock.now_ns() + START_DELAY_NS;
        self.fleet.begin(later_ns);
        let start = Monotonic::now().plus_ns(START_DELAY_NS);
        self.clock = WallClock::new(start);
        self.end.publish(0, &self.starting_encoders())?;
        let wake_page = self.presence.wake_page();
        wake_page.set_start_ns(start.to_shared());
        wake_page.advance(Stage::Running);
        loop {
            let heard = self.hear(LOOK_INTERVAL);
            let now_ns = self.clock.now_ns();
            if now_ns >= end_ns {
                return Ok(());
            }
            self.end.check_running()?;
            if heard {
                self.end.publish(now_ns.max(0), &self.fleet.encoders())?;
            }
            let fleet = &mut self.fleet;
            self.end
                .drain_commands(|command| fleet.tell(command, now_ns))?;
            self.tell(now_ns);
            self.say_changes()?;
            if self.spacing.is_due(now_ns) {
                self.spacing.measure(now_ns, &self.fleet.poses());
            }
            let error_m = self.spacing.largest();
            wake_page.publish_progress(now_ns.max(0), 0.0, error_m);
            self.records.flush_if_due();
        }
    }

    /// The encoders before time 0: as if they had been read at 0.
    fn starting_encoders(&self) -> Vec<Encoders> {
        let mut encoders = self.fleet.encoders();
        for own in &mut encoders {
            own.sampled_ns = own.sampled_ns.max(0);
        }
        encoders
    }

    /// Tells every robot what is due.
    fn tell(&mut self, now_ns: i64) {
        for (robot, lab) in self.lab.robots.iter().enumerate() {
            let due = self.fleet.due(robot, now_ns, &mut self.records);
            if let Some(told) = due {
                let payload = payload(told, lab.command.message);
                self.topics.publish(robot, payload);
            }
        }
    }

    /// Says who stands, and ends the run for it where the experiment says so.
    fn say_changes(&mut self) -> Result<(), BusError> {
        for change in self.fleet.changes() {
            let Some(robot) = self.lab.robots.get(change.robot) else {
                continue;
            };
            let ends = self.experiment.settings.on_death == OnDeath::Stop;
            let reason = match change.standing {
                Some(Standing::NotHeard) => {
                    let silence = self.experiment.settings.control.watchdog_s;
                    format!(
                        "nothing came from /{} for {silence} s",
                        robot.wheels.topic()
                    )
                }
                Some(Standing::TooFast) => {
                    "its wheels were faster than its limits allow".to_owned()
                }
                Some(Standing::AgentLost) if ends => "its agent went silent".to_owned(),
                Some(Standing::AgentSilent) => {
                    (self.notice)(&format!(
                        "{}: its agent is silent: told to stand",
                        robot.name
                    ));
                    continue;
                }
                Some(Standing::Idle | Standing::AgentLost) | None => continue,
            };
            if ends {
                return Err(BusError::Failed {
                    what: robot.name.clone(),
                    reason: format!("{reason}; all robots were told to stand"),
                });
            }
            (self.notice)(&format!("{}: {reason}: told to stand", robot.name));
        }
        Ok(())
    }

    /// Tells all robots to stand, until it is certain that they have heard it.
    fn leave(&mut self) {
        self.fleet.stop();
        let begin = Instant::now();
        while begin.elapsed() < LEAVE_FOR {
            self.tell(self.clock.now_ns());
            self.presence.show();
            self.hear(LOOK_INTERVAL);
        }
    }
}

/// The message that tells a robot what it is told.
fn payload(told: Actuation, message: CommandMessage) -> Vec<u8> {
    let (Actuation::Twist(pair) | Actuation::Torque(pair)) = told;
    match message {
        CommandMessage::Twist => wire::twist(pair),
        CommandMessage::TwistStamped => wire::twist_stamped(system_ns(), pair),
        CommandMessage::Efforts { left_first, .. } => {
            let [right, left] = pair;
            wire::two_numbers(if left_first { [left, right] } else { pair })
        }
    }
}

impl Drop for Robots<'_> {
    /// Whatever ends the process, robots are told to stand.
    fn drop(&mut self) {
        self.fleet.stop();
        self.tell(self.clock.now_ns());
    }
}
