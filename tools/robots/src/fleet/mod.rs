//! Fleet: the robots of a run between their agents and their topics.
//!
//! It has no I/O, clock or threads. Times are ns of the run's clock, negative before the run begins. Every twist that
//! leaves it is within the limits of `robots.toml`, and follows the last one with their accelerations; every torque is
//! within its limit. A robot is told to stand while the run has not begun or is over, while it is not heard for
//! `control.watchdog_s`, while its agent is silent, and, if it takes torques, from when its wheels are too fast.

mod link;
mod report;
mod stamps;
mod wheels;

use slipstream_bus::Experiment;
use slipstream_bus::message::{Actuation, DriveCommand, Encoders};
use slipstream_bus::record::Recorder;
use slipstream_bus::time::ns_from_s;

use self::link::Link;
pub use self::link::Standing;
pub use self::report::{RobotReport, Stream};
use crate::lab::{Content, Lab};
use crate::topics::{Opening, Topic};

/// Number of outer periods without a command after which an agent is silent.
const SILENT_PERIODS: f64 = 3.0;

/// The robots of a run.
#[derive(Debug)]
pub struct Fleet {
    links: Vec<Link>,
    /// The place of each heard topic: robot, and what it tells.
    heard: Vec<(usize, Content)>,
    stopped: bool,
}

/// A message of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measured {
    /// Index of the robot.
    pub robot: usize,
    /// What it told.
    pub content: Content,
    /// When that was measured, by its stamp (ns of the run's clock).
    pub measured_ns: i64,
}

/// A robot whose state has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// Index of the robot.
    pub robot: usize,
    /// Why it stands; `None`: it drives.
    pub standing: Option<Standing>,
}

impl Fleet {
    /// The robots of a lab in an experiment, which has as many.
    pub fn new(experiment: &Experiment, lab: &Lab) -> Self {
        let settings = &experiment.settings;
        let silent_s = SILENT_PERIODS * settings.control.outer_period_s;
        let silences = link::Silences {
            agent_ns: ns_from_s(settings.plant.command_timeout_s.max(silent_s)),
            robot_ns: ns_from_s(settings.control.watchdog_s),
            period_ns: ns_from_s(settings.control.outer_period_s),
        };
        let pairs = experiment.robots.iter().zip(&lab.robots);
        let heard = pairs
            .clone()
            .enumerate()
            .flat_map(|(robot, (_, own))| Content::of(own).map(move |content| (robot, content)));
        Self {
            heard: heard.collect(),
            links: pairs
                .enumerate()
                .map(|(robot, (setup, own))| Link::new(robot, setup, own, silences))
                .collect(),
            stopped: false,
        }
    }

    /// How the topics of a lab are opened: commands are published by robot, and heard is what [`Self::hear`] takes.
    pub fn opening(lab: &Lab) -> Opening<'_> {
        let heard = |robot| Content::of(robot).filter_map(move |content| Topic::of(content, robot));
        Opening {
            connect: lab.addresses(),
            listen: Vec::new(),
            security: &lab.security,
            wire: lab.wire,
            published: lab.robots.iter().map(Topic::of_command).collect(),
            heard: lab.robots.iter().flat_map(heard).collect(),
        }
    }

    /// Takes a message of the topic at `place` that arrived at `arrived_ns`. Returns what it was, if it could be read.
    pub fn hear(
        &mut self,
        place: usize,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Option<Measured> {
        let &(robot, content) = self.heard.get(place)?;
        let link = self.links.get_mut(robot)?;
        let measured_ns = link.hear(content, payload, arrived_ns, recorder)?;
        Some(Measured {
            robot,
            content,
            measured_ns,
        })
    }

    /// Takes a command of an agent that arrived at `now_ns`.
    pub fn tell(&mut self, command: &DriveCommand, now_ns: i64) {
        if let Some(link) = self.links.get_mut(command.robot as usize) {
            link.tell(command, now_ns);
        }
    }

    /// From now on the run goes on: time 0 is what was `later_ns` before, counts begin at 0, and robots may drive.
    pub fn begin(&mut self, later_ns: i64) {
        for link in &mut self.links {
            link.begin(later_ns);
        }
    }

    /// From now on all robots stand.
    pub fn stop(&mut self) {
        self.stopped = true;
    }

    /// What a robot is to be told now, if there is anything to tell. Before the run has begun there is nothing.
    pub fn due(
        &mut self,
        robot: usize,
        now_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Option<Actuation> {
        let stopped = self.stopped;
        let link = self.links.get_mut(robot)?;
        link.due(now_ns, stopped, recorder)
    }

    /// What has changed since the last call.
    pub fn changes(&mut self) -> Vec<Change> {
        let changed = self.links.iter_mut().enumerate();
        let changed = changed.filter_map(|(robot, link)| {
            let standing = link.changed()?;
            Some(Change { robot, standing })
        });
        changed.collect()
    }

    /// The encoders of all robots, for their agents.
    pub fn encoders(&self) -> Vec<Encoders> {
        self.links.iter().map(Link::encoders).collect()
    }

    /// The robots from which nothing has come of a topic.
    pub fn unheard(&self) -> Vec<(usize, Content)> {
        let is_unheard = |&&(robot, content): &&(usize, Content)| {
            let link = self.links.get(robot);
            link.is_some_and(|link| !link.has_heard(content))
        };
        self.heard.iter().filter(is_unheard).copied().collect()
    }

    /// The last pose of each robot: x (m), y (m), yaw (rad) of c.
    pub fn poses(&self) -> Vec<Option<[f64; 3]>> {
        self.links.iter().map(Link::pose).collect()
    }

    /// What became of each robot.
    pub fn reports(&self) -> Vec<RobotReport> {
        self.links.iter().map(Link::report).collect()
    }
}
