//! One robot of a fleet: what was heard of it, and what it is told.

use slipstream_bus::experiment::RobotSetup;
use slipstream_bus::message::{Actuation, DriveCommand, Encoders, RobotIndex};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::time::s_from_ns;
use slipstream_recording::wire;

use super::content::Content;
use super::report::{RobotReport, Stream};
use super::stamps::StampClock;
use super::wheels::Wheels;
use crate::lab::{LabRobot, WheelTopic};

/// Time after which a robot that stands is told so again (ns).
const REPEAT_NS: i64 = 50_000_000;

/// Why a robot is told to stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The run has not begun, or is over.
    Idle,
    /// It is not heard.
    NotHeard,
    /// Its agent is silent.
    AgentSilent,
    /// Its agent has been silent for as long as a robot may be.
    AgentLost,
}

/// Times without a message after which a robot stands (ns).
#[derive(Debug, Clone, Copy)]
pub(super) struct Silences {
    /// Of its agent.
    pub(super) agent_ns: i64,
    /// Of the robot.
    pub(super) robot_ns: i64,
    /// Period of commands.
    pub(super) period_ns: i64,
}

#[derive(Debug)]
pub(super) struct Link {
    robot: RobotIndex,
    lab: LabRobot,
    /// d: distance from c backwards to the axle (m).
    com_to_axle_m: f64,
    silences: Silences,
    wheels: Wheels,
    encoders: Encoders,
    /// When wheels and pose were heard last (ns).
    heard_ns: [Option<i64>; 2],
    clocks: [StampClock; 2],
    /// Time of the newest message of wheels and pose (ns).
    newest_ns: [i64; 2],
    /// The newest command of the agent, and when it came.
    told: Option<(DriveCommand, i64)>,
    /// The twist that the robot was told last, when, and for which tick of the agent.
    sent: [f64; 2],
    sent_ns: Option<i64>,
    sent_tick_ns: Option<i64>,
    begun: bool,
    standing: Option<Standing>,
    changed: bool,
    report: RobotReport,
}

impl Link {
    pub(super) fn new(
        robot: usize,
        setup: &RobotSetup,
        lab: &LabRobot,
        silences: Silences,
    ) -> Self {
        let body = &setup.model.robot;
        let limits = &lab.limits;
        let rim_m_s = limits.speed_m_s + body.half_track_m * limits.yaw_rate_rad_s;
        Self {
            robot: RobotIndex::try_from(robot).unwrap_or(RobotIndex::MAX),
            lab: lab.clone(),
            com_to_axle_m: body.com_to_axle_m.unwrap_or(0.0),
            silences,
            wheels: Wheels::new(&setup.model, rim_m_s / body.wheel_radius_m),
            encoders: Encoders::default(),
            heard_ns: [None; 2],
            clocks: [StampClock::default(); 2],
            newest_ns: [i64::MIN; 2],
            told: None,
            sent: [0.0; 2],
            sent_ns: None,
            sent_tick_ns: None,
            begun: false,
            standing: Some(Standing::Idle),
            changed: false,
            report: RobotReport::default(),
        }
    }

    pub(super) fn hear(
        &mut self,
        content: Content,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) {
        let read = match content {
            Content::Wheels => self.read_wheels(payload, arrived_ns, recorder),
            Content::Pose => self.read_pose(payload, arrived_ns, recorder),
        };
        let stream = self.stream(content);
        if let Err(problem) = read {
            stream.unreadable += 1;
            let topic = content.topic(&self.lab);
            let problem = || format!("a message of {topic} {problem}");
            self.report.problem.get_or_insert_with(problem);
            return;
        }
        let last_ns = self.heard_ns[content as usize].replace(arrived_ns);
        let gap_s = last_ns.map_or(0.0, |last_ns| s_from_ns(arrived_ns - last_ns));
        let latest_s = s_from_ns(self.clocks[content as usize].latest_ns);
        let begun = self.begun;
        let stream = self.stream(content);
        stream.messages += 1;
        stream.latest_s = latest_s;
        if begun {
            stream.longest_gap_s = stream.longest_gap_s.max(gap_s);
        }
    }

    fn stream(&mut self, content: Content) -> &mut Stream {
        match content {
            Content::Wheels => &mut self.report.wheels,
            Content::Pose => &mut self.report.poses,
        }
    }

    fn read_wheels(
        &mut self,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Result<(), String> {
        let robot = self.robot;
        let (t_ns, record) = match &self.lab.wheels {
            WheelTopic::Joints {
                joints: [right, left],
                ..
            } => {
                let angles = wire::read_joint_angles(payload, [right, left])?;
                let t_ns = self.time(Content::Wheels, angles.stamp_ns, arrived_ns)?;
                self.wheels.take_angles(angles.value, t_ns);
                let angle_rad = angles.value;
                let record = Record::WheelAngles {
                    t_ns,
                    robot,
                    angle_rad,
                };
                (t_ns, record)
            }
            WheelTopic::Odometry { .. } => {
                let odometry = wire::read_odometry(payload)?;
                let t_ns = self.time(Content::Wheels, odometry.stamp_ns, arrived_ns)?;
                let wire::OdometryValue { pose, velocity } = odometry.value;
                self.wheels.take_pose(pose);
                let record = Record::RobotOdometry {
                    t_ns,
                    robot,
                    pose,
                    velocity,
                };
                (t_ns, record)
            }
        };
        self.encoders = self.wheels.encoders(t_ns);
        if self.begun && t_ns >= 0 {
            recorder.record(&record);
        }
        Ok(())
    }

    fn read_pose(
        &mut self,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Result<(), String> {
        let pose = wire::read_pose(payload)?;
        let t_ns = self.time(Content::Pose, pose.stamp_ns, arrived_ns)?;
        let [x, y, yaw] = pose.value;
        let is_axle = self.lab.pose.as_ref().is_some_and(|own| own.is_axle);
        let ahead = if is_axle { self.com_to_axle_m } else { 0.0 };
        let pose = [x + ahead * yaw.cos(), y + ahead * yaw.sin(), yaw];
        self.report.last_pose = Some(pose);
        if self.begun && t_ns >= 0 {
            let robot = self.robot;
            recorder.record(&Record::Camera { t_ns, robot, pose });
        }
        Ok(())
    }

    /// When a message was stamped, on the clock of the run (ns).
    fn time(&mut self, content: Content, stamp_ns: i64, arrived_ns: i64) -> Result<i64, String> {
        let place = content as usize;
        let t_ns = self.clocks[place].on_run(stamp_ns, arrived_ns);
        if t_ns <= self.newest_ns[place] {
            return Err("is not newer than the one before".to_owned());
        }
        self.newest_ns[place] = t_ns;
        Ok(t_ns)
    }

    pub(super) fn tell(&mut self, command: &DriveCommand, now_ns: i64) {
        self.told = Some((*command, now_ns));
    }

    pub(super) fn begin(&mut self, later_ns: i64) {
        self.begun = true;
        self.wheels.begin();
        self.encoders = self.wheels.encoders(self.encoders.sampled_ns - later_ns);
        for place in 0..2 {
            self.clocks[place].begin(later_ns);
            self.heard_ns[place] = self.heard_ns[place].map(|own| own - later_ns);
            self.newest_ns[place] = self.newest_ns[place].saturating_sub(later_ns);
        }
    }

    /// Why the robot has to stand.
    fn reason(&self, now_ns: i64, stopped: bool) -> Option<Standing> {
        let Some((_, told_ns)) = self.told else {
            return Some(Standing::Idle);
        };
        let unheard_ns = self.heard_ns[Content::Wheels as usize].map(|own| now_ns - own);
        if stopped {
            Some(Standing::Idle)
        } else if unheard_ns.is_none_or(|own| own > self.silences.robot_ns) {
            Some(Standing::NotHeard)
        } else if now_ns - told_ns > self.silences.robot_ns.max(self.silences.agent_ns) {
            Some(Standing::AgentLost)
        } else if now_ns - told_ns > self.silences.agent_ns {
            Some(Standing::AgentSilent)
        } else {
            None
        }
    }

    pub(super) fn due(
        &mut self,
        now_ns: i64,
        stopped: bool,
        recorder: &mut impl Recorder,
    ) -> Option<[f64; 2]> {
        if !self.begun {
            return None;
        }
        let standing = self.reason(now_ns, stopped);
        if standing != self.standing {
            self.note(standing, now_ns, recorder);
        }
        let since_ns = self.sent_ns.map(|sent_ns| now_ns - sent_ns);
        let twist = match (standing, self.told) {
            (Some(_), _) => {
                let is_fresh = since_ns.is_some_and(|since_ns| since_ns < REPEAT_NS);
                if self.sent == [0.0; 2] && is_fresh {
                    return None;
                }
                [0.0; 2]
            }
            (None, Some((command, _))) => {
                if self.sent_tick_ns == Some(command.tick_ns) {
                    return None;
                }
                let last_ns = self.sent_tick_ns.replace(command.tick_ns);
                self.cut(
                    &command,
                    s_from_ns(self.time_to_accelerate(last_ns, command.tick_ns)),
                )
            }
            (None, None) => return None,
        };
        self.record(twist, now_ns, recorder);
        (self.sent, self.sent_ns) = (twist, Some(now_ns));
        self.report.commands += 1;
        Some(twist)
    }

    /// The time (ns) within which speeds may change from the command for the tick `last_ns` to that for `tick_ns`: not more
    /// than two periods, so that nothing jumps after a pause.
    fn time_to_accelerate(&self, last_ns: Option<i64>, tick_ns: i64) -> i64 {
        let period_ns = self.silences.period_ns;
        let since_ns = last_ns.map_or(period_ns, |last_ns| tick_ns - last_ns);
        since_ns.clamp(0, 2 * period_ns)
    }

    /// The twist of a command within the limits.
    fn cut(&mut self, command: &DriveCommand, after_s: f64) -> [f64; 2] {
        let wanted = match command.actuation {
            Actuation::Twist(twist) => twist,
            Actuation::Torque(_) => [0.0; 2],
        };
        let twist = self.lab.limits.cut(wanted, self.sent, after_s);
        self.report.cut += u64::from(twist != wanted);
        twist
    }

    /// Records what the robot is told. Of a robot that stands the first command says it all.
    fn record(&self, twist: [f64; 2], now_ns: i64, recorder: &mut impl Recorder) {
        if now_ns < 0 || (self.sent == twist && self.standing.is_some()) {
            return;
        }
        let tick_ns = self.told.map_or(0, |(command, _)| command.tick_ns);
        recorder.record(&Record::Applied {
            t_ns: now_ns,
            taken_ns: now_ns,
            robot: self.robot,
            tick_ns,
            actuation: Actuation::Twist(twist),
        });
    }

    fn note(&mut self, standing: Option<Standing>, now_ns: i64, recorder: &mut impl Recorder) {
        let kind = match (self.standing, standing) {
            (_, Some(Standing::NotHeard)) => Some(EventKind::RobotLost),
            (_, Some(Standing::AgentSilent)) => Some(EventKind::AgentSilent),
            (Some(Standing::Idle) | None, None)
            | (_, Some(Standing::Idle | Standing::AgentLost)) => None,
            (Some(_), None) => Some(EventKind::RobotBack),
        };
        if let Some(kind) = kind {
            let robot = Some(self.robot);
            let t_ns = now_ns;
            recorder.record(&Record::Event { t_ns, robot, kind });
            self.report.stops += u64::from(kind != EventKind::RobotBack);
        }
        self.standing = standing;
        self.changed = true;
    }

    /// Why it stands, if that has changed since the last call.
    pub(super) fn changed(&mut self) -> Option<Option<Standing>> {
        std::mem::take(&mut self.changed).then_some(self.standing)
    }

    pub(super) fn encoders(&self) -> Encoders {
        self.encoders
    }

    pub(super) fn has_heard(&self, content: Content) -> bool {
        self.heard_ns[content as usize].is_some()
    }

    pub(super) fn pose(&self) -> Option<[f64; 3]> {
        self.report.last_pose
    }

    pub(super) fn report(&self) -> RobotReport {
        RobotReport {
            jumps: self.wheels.jumps,
            ..self.report.clone()
        }
    }
}
