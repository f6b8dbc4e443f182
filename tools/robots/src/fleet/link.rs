//! One robot of a fleet: what was heard of it, and what it is told.

use slipstream_bag::ros::wire;
use slipstream_bus::experiment::{Drive, RobotSetup};
use slipstream_bus::message::{Actuation, DriveCommand, Encoders, RobotIndex};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::time::s_from_ns;

use super::report::RobotReport;
use super::stamps::StampClock;
use super::wheels::Wheels;
use crate::lab::{CONTENTS, CommandMessage, Content, LabRobot, WheelTopic};

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
    /// It takes torques, and its wheels were faster than its limits allow.
    TooFast,
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
    /// When each content was heard last (ns).
    heard_ns: [Option<i64>; CONTENTS],
    clocks: [StampClock; CONTENTS],
    /// Time of the newest message of each content (ns).
    newest_ns: [i64; CONTENTS],
    /// The newest command of the agent, and when it came.
    told: Option<(DriveCommand, i64)>,
    /// What the robot was told last, when, and for which tick of the agent.
    sent: Actuation,
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
            heard_ns: [None; CONTENTS],
            clocks: [StampClock::default(); CONTENTS],
            newest_ns: [i64::MIN; CONTENTS],
            told: None,
            sent: lab.command.message.rest(),
            sent_ns: None,
            sent_tick_ns: None,
            begun: false,
            standing: Some(Standing::Idle),
            changed: false,
            report: RobotReport::default(),
        }
    }

    /// Takes a message. Returns when it was measured (ns), if it could be read.
    pub(super) fn hear(
        &mut self,
        content: Content,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Option<i64> {
        let read = match content {
            Content::Wheels => self.read_wheels(payload, arrived_ns, recorder),
            Content::Pose => self.read_pose(payload, arrived_ns, recorder),
            Content::Odometry => self.read_odometry(payload, arrived_ns, recorder),
            Content::Imu => self.read_imu(payload, arrived_ns, recorder),
        };
        let begun = self.begun;
        let latest_s = s_from_ns(self.clocks[content as usize].latest_ns);
        let stream = self.report.stream_mut(content);
        let measured_ns = match read {
            Ok(measured_ns) => measured_ns,
            Err(problem) => {
                stream.unreadable += 1;
                let topic = content.topic(&self.lab).unwrap_or_default();
                let problem = || format!("a message of {topic} {problem}");
                self.report.problem.get_or_insert_with(problem);
                return None;
            }
        };
        let last_ns = self.heard_ns[content as usize].replace(arrived_ns);
        let gap_s = last_ns.map_or(0.0, |last_ns| s_from_ns(arrived_ns - last_ns));
        stream.messages += 1;
        stream.latest_s = latest_s;
        if begun {
            stream.longest_gap_s = stream.longest_gap_s.max(gap_s);
        }
        Some(measured_ns)
    }

    fn read_wheels(
        &mut self,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Result<i64, String> {
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
                let (t_ns, pose, record) = self.odometry(Content::Wheels, payload, arrived_ns)?;
                self.wheels.take_pose(pose, t_ns);
                (t_ns, record)
            }
        };
        self.encoders = self.wheels.encoders(t_ns);
        self.keep(t_ns, &record, recorder);
        Ok(t_ns)
    }

    /// Records what was measured while the run goes on.
    fn keep(&self, t_ns: i64, record: &Record, recorder: &mut impl Recorder) {
        if self.begun && t_ns >= 0 {
            recorder.record(record);
        }
    }

    /// Reads the robot's own odometry, beside its wheels.
    fn read_odometry(
        &mut self,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Result<i64, String> {
        let (t_ns, _, record) = self.odometry(Content::Odometry, payload, arrived_ns)?;
        self.keep(t_ns, &record, recorder);
        Ok(t_ns)
    }

    /// An odometry that tells this content: when it was stamped (ns), its pose, and its record.
    fn odometry(
        &mut self,
        content: Content,
        payload: &[u8],
        arrived_ns: i64,
    ) -> Result<(i64, [f64; 3], Record), String> {
        let odometry = wire::read_odometry(payload)?;
        let t_ns = self.time(content, odometry.stamp_ns, arrived_ns)?;
        let wire::OdometryValue { pose, velocity } = odometry.value;
        let record = Record::RobotOdometry {
            t_ns,
            robot: self.robot,
            pose,
            velocity,
        };
        Ok((t_ns, pose, record))
    }

    fn read_imu(
        &mut self,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Result<i64, String> {
        let imu = wire::read_imu(payload)?;
        let t_ns = self.time(Content::Imu, imu.stamp_ns, arrived_ns)?;
        let wire::ImuValue {
            acceleration_m_s2,
            yaw_rate_rad_s,
        } = imu.value;
        let record = Record::Imu {
            t_ns,
            robot: self.robot,
            acceleration_m_s2,
            yaw_rate_rad_s,
        };
        self.keep(t_ns, &record, recorder);
        Ok(t_ns)
    }

    fn read_pose(
        &mut self,
        payload: &[u8],
        arrived_ns: i64,
        recorder: &mut impl Recorder,
    ) -> Result<i64, String> {
        let pose = wire::read_pose(payload)?;
        let t_ns = self.time(Content::Pose, pose.stamp_ns, arrived_ns)?;
        let [x, y, yaw] = pose.value;
        let is_axle = self.lab.pose.as_ref().is_some_and(|own| own.is_axle);
        let ahead = if is_axle { self.com_to_axle_m } else { 0.0 };
        let pose = [x + ahead * yaw.cos(), y + ahead * yaw.sin(), yaw];
        self.report.last_pose = Some(pose);
        let robot = self.robot;
        self.keep(t_ns, &Record::Camera { t_ns, robot, pose }, recorder);
        Ok(t_ns)
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
        for place in 0..CONTENTS {
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
        } else if self.is_too_fast() {
            Some(Standing::TooFast)
        } else if now_ns - told_ns > self.silences.robot_ns.max(self.silences.agent_ns) {
            Some(Standing::AgentLost)
        } else if now_ns - told_ns > self.silences.agent_ns {
            Some(Standing::AgentSilent)
        } else {
            None
        }
    }

    /// Whether the wheels of a robot that takes torques have turned faster than its limits allow. It stays so.
    fn is_too_fast(&self) -> bool {
        let takes_torques = self.lab.command.message.drive() == Drive::Torque;
        takes_torques && self.wheels.was_too_fast
    }

    pub(super) fn due(
        &mut self,
        now_ns: i64,
        stopped: bool,
        recorder: &mut impl Recorder,
    ) -> Option<Actuation> {
        if !self.begun {
            return None;
        }
        let standing = self.reason(now_ns, stopped);
        if standing != self.standing {
            self.note(standing, now_ns, recorder);
        }
        let since_ns = self.sent_ns.map(|sent_ns| now_ns - sent_ns);
        let rest = self.lab.command.message.rest();
        let told = match (standing, self.told) {
            (Some(_), _) => {
                let is_fresh = since_ns.is_some_and(|since_ns| since_ns < REPEAT_NS);
                if self.sent == rest && is_fresh {
                    return None;
                }
                rest
            }
            (None, Some((command, _))) => {
                if self.sent_tick_ns == Some(command.tick_ns) {
                    return None;
                }
                let last_ns = self.sent_tick_ns.replace(command.tick_ns);
                let after_s = s_from_ns(self.time_to_accelerate(last_ns, command.tick_ns));
                self.cut(&command, after_s)
            }
            (None, None) => return None,
        };
        self.record(told, now_ns, recorder);
        (self.sent, self.sent_ns) = (told, Some(now_ns));
        self.report.commands += 1;
        Some(told)
    }

    /// The time (ns) within which speeds may change from the command for the tick `last_ns` to that for `tick_ns`: not more
    /// than two periods, so that nothing jumps after a pause.
    fn time_to_accelerate(&self, last_ns: Option<i64>, tick_ns: i64) -> i64 {
        let period_ns = self.silences.period_ns;
        let since_ns = last_ns.map_or(period_ns, |last_ns| tick_ns - last_ns);
        since_ns.clamp(0, 2 * period_ns)
    }

    /// What a command tells, within the limits. A command of another kind than the robot takes lets it stand.
    fn cut(&mut self, command: &DriveCommand, after_s: f64) -> Actuation {
        let told = match (command.actuation, self.sent, self.lab.command.message) {
            (Actuation::Twist(wanted), Actuation::Twist(last), _) => {
                Actuation::Twist(self.lab.limits.cut(wanted, last, after_s))
            }
            (Actuation::Torque(wanted), _, CommandMessage::Efforts { torque_nm, .. }) => {
                Actuation::Torque(wanted.map(|own| {
                    let own = if own.is_finite() { own } else { 0.0 };
                    own.clamp(-torque_nm, torque_nm)
                }))
            }
            (_, _, message) => message.rest(),
        };
        self.report.cut += u64::from(told != command.actuation);
        told
    }

    /// Records what the robot is told. Of a robot that stands the first command says it all.
    fn record(&self, told: Actuation, now_ns: i64, recorder: &mut impl Recorder) {
        if now_ns < 0 || (self.sent == told && self.standing.is_some()) {
            return;
        }
        let tick_ns = self.told.map_or(0, |(command, _)| command.tick_ns);
        recorder.record(&Record::Applied {
            t_ns: now_ns,
            taken_ns: now_ns,
            robot: self.robot,
            tick_ns,
            actuation: told,
        });
    }

    fn note(&mut self, standing: Option<Standing>, now_ns: i64, recorder: &mut impl Recorder) {
        let kind = match (self.standing, standing) {
            (_, Some(Standing::NotHeard)) => Some(EventKind::RobotLost),
            (_, Some(Standing::AgentSilent)) => Some(EventKind::AgentSilent),
            (Some(Standing::Idle) | None, None)
            | (_, Some(Standing::Idle | Standing::AgentLost | Standing::TooFast)) => None,
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
