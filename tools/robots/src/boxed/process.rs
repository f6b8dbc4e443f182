//! The process of a robot in a box: on the wall clock, behind topics.

use std::io::Write;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use slipstream_bag::ros::wire;
use slipstream_bus::message::Actuation;
use slipstream_bus::transport::BusError;
use slipstream_bus::{Camera, Imu, InputError, RobotModel, Sensors};
use slipstream_ipc::clock::{Monotonic, WallClock};

use super::robot::{BoxedRobot, Measured};
use crate::lab::{CommandMessage, Content, Lab, LabRobot, WheelTopic};
use crate::system_clock::system_ns;
use crate::topics::{self, Opening, Topic, Topics};

/// Longest wait for a command before the plant goes on.
const LOOK_INTERVAL: Duration = Duration::from_millis(1);

/// What a box is.
#[derive(Debug, Clone)]
pub struct BoxOptions<'a> {
    /// Its model, with the effects that it conceals.
    pub model: &'a RobotModel,
    /// Where it stands: x (m), y (m), yaw (rad) of c.
    pub pose: [f64; 3],
    /// What tracks it.
    pub camera: Camera,
    /// Its inertial sensor, for a robot that has a topic for it.
    pub imu: Imu,
    /// Rate of wheels or odometry (1/s).
    pub wheels_hz: f64,
    /// It stands when no command has come for so long (s), as base controllers do.
    pub command_timeout_s: f64,
    /// Seed of its noise.
    pub seed: u64,
}

/// What a box has seen.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BoxReport {
    /// Commands that came.
    pub commands: u64,
    /// Commands that could not be read.
    pub unreadable: u64,
    /// Largest speed (m/s) and yaw rate (rad/s) that it was told, or largest torque of each wheel (N m).
    pub largest: [f64; 2],
    /// Largest change of the same from one command to the next.
    pub largest_step: [f64; 2],
    /// Its true pose at the end: x (m), y (m), yaw (rad) of c.
    pub final_pose: [f64; 3],
}

/// Plays the robot `robot` of a lab until `goes_on` says no. Every change of what it follows is a line of `log`: time of
/// the system's monotonic clock (ns), then v (m/s) and w (rad/s), or the torques of the right and the left wheel (N m).
///
/// # Errors
/// Its model cannot be simulated, or the network cannot be used.
pub fn run(
    lab: &Lab,
    robot: &LabRobot,
    options: &BoxOptions<'_>,
    log: &mut dyn Write,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<BoxReport, BoxError> {
    // A robot whose address is its own listens there; robots behind one router connect to it.
    let shares = lab.robots.iter().filter(|own| own.address == robot.address);
    let (connect, listen) = match shares.count() {
        1 => (Vec::new(), vec![&robot.address]),
        _ => (vec![&robot.address], Vec::new()),
    };
    let topics = topics::open(&Opening {
        connect,
        listen,
        security: &lab.security,
        wire: lab.wire,
        published: Content::of(robot)
            .filter_map(|content| Topic::of(content, robot))
            .collect(),
        heard: vec![Topic::of_command(robot)],
    })?;
    run_over(topics, robot, options, log, goes_on)
}

/// As [`run`], over topics that are open: what the robot has topics for is published in the order of [`Content::ALL`],
/// commands are heard.
///
/// # Errors
/// Its model cannot be simulated.
pub fn run_over(
    topics: Box<dyn Topics>,
    robot: &LabRobot,
    options: &BoxOptions<'_>,
    log: &mut dyn Write,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<BoxReport, BoxError> {
    let timeout_ns = (options.command_timeout_s * 1e9) as i64;
    let sensors = Sensors {
        camera: robot.pose.is_some().then(|| options.camera.clone()),
        imu: robot.imu.is_some().then(|| options.imu.clone()),
    };
    let rest = robot.command.message.rest();
    let own = BoxedRobot::new(
        &robot.name,
        options.model,
        options.pose,
        sensors,
        rest,
        timeout_ns,
        options.seed,
    )?;
    let mut playing = Playing {
        robot,
        own,
        topics,
        start: Monotonic::now(),
        start_system_ns: system_ns(),
        period_ns: (1e9 / options.wheels_hz) as i64,
        due_ns: 0,
        followed: rest,
        report: BoxReport::default(),
    };
    while goes_on() {
        playing.step(log)?;
    }
    playing.report.final_pose = playing.own.true_pose();
    Ok(playing.report)
}

/// Why a box cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum BoxError {
    /// Its model.
    #[error(transparent)]
    Model(#[from] InputError),
    /// The network.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The log.
    #[error("the log cannot be written: {0}")]
    Log(#[from] std::io::Error),
}

struct Playing<'a> {
    robot: &'a LabRobot,
    own: BoxedRobot,
    topics: Box<dyn Topics>,
    start: Monotonic,
    /// Time of the system at the start (ns since 1970): stamps go on from it.
    start_system_ns: i64,
    period_ns: i64,
    due_ns: i64,
    followed: Actuation,
    report: BoxReport,
}

impl Playing<'_> {
    /// Takes commands for a moment, then advances to now, and sends what was measured.
    fn step(&mut self, log: &mut dyn Write) -> Result<(), BoxError> {
        let clock = WallClock::new(self.start);
        let mut timeout = LOOK_INTERVAL;
        let begin = Instant::now();
        while let Some(heard) = self.topics.receive(timeout) {
            timeout = Duration::ZERO;
            let at_ns = clock.ns_at(heard.arrived);
            self.take(&heard.payload, at_ns);
            if begin.elapsed() > LOOK_INTERVAL {
                break;
            }
        }
        let now_ns = clock.now_ns();
        let mut measured = Vec::new();
        self.own.advance(now_ns, |own| measured.push(own));
        for own in measured {
            self.send_measured(own);
        }
        if now_ns >= self.due_ns {
            self.due_ns = (now_ns / self.period_ns + 1) * self.period_ns;
            self.send_wheels();
        }
        self.log_change(now_ns, log)?;
        Ok(())
    }

    fn take(&mut self, payload: &[u8], now_ns: i64) {
        let Ok(command) = read_command(payload, self.robot.command.message) else {
            self.report.unreadable += 1;
            return;
        };
        let (told, before) = (pair(command), pair(self.own.followed(now_ns)));
        for i in 0..2 {
            let [largest, step] = [
                &mut self.report.largest[i],
                &mut self.report.largest_step[i],
            ];
            *largest = largest.max(told[i].abs());
            // A stop is allowed to be sudden.
            if told != [0.0; 2] {
                *step = step.max((told[i] - before[i]).abs());
            }
        }
        self.report.commands += 1;
        self.own.tell(command, now_ns);
    }

    fn send_measured(&mut self, measured: Measured) {
        let start_ns = self.start_system_ns;
        match measured {
            Measured::Pose(t_ns, [x, y, yaw]) => {
                let is_axle = self.robot.pose.as_ref().is_some_and(|pose| pose.is_axle);
                let back = if is_axle {
                    self.own.com_to_axle_m()
                } else {
                    0.0
                };
                let pose = [x - back * yaw.cos(), y - back * yaw.sin(), yaw];
                self.publish(Content::Pose, wire::pose(start_ns + t_ns, pose));
            }
            Measured::Imu(t_ns, value) => {
                self.publish(Content::Imu, wire::imu(start_ns + t_ns, value));
            }
        }
    }

    fn send_wheels(&mut self) {
        let stamp_ns = self.start_system_ns + self.own.time_ns();
        let odometry = wire::odometry(stamp_ns, &self.robot.name, self.own.odometry());
        match &self.robot.wheels {
            WheelTopic::Joints {
                joints: [right, left],
                ..
            } => {
                let angles = self.own.wheel_angles();
                let message = wire::joint_angles(stamp_ns, [right, left], angles);
                self.publish(Content::Wheels, message);
                self.publish(Content::Odometry, odometry);
            }
            WheelTopic::Odometry { .. } => self.publish(Content::Wheels, odometry),
        }
    }

    /// Publishes what the robot has a topic for.
    fn publish(&mut self, content: Content, message: Vec<u8>) {
        let place = Content::of(self.robot).position(|own| own == content);
        if let Some(place) = place {
            self.topics.publish(place, message);
        }
    }

    fn log_change(&mut self, now_ns: i64, log: &mut dyn Write) -> std::io::Result<()> {
        let followed = self.own.followed(now_ns);
        if followed != self.followed {
            self.followed = followed;
            let at_ns = self.start.plus_ns(now_ns).to_shared();
            let [first, second] = pair(followed);
            writeln!(log, "{at_ns},{first},{second}")?;
        }
        Ok(())
    }
}

fn read_command(payload: &[u8], message: CommandMessage) -> Result<Actuation, String> {
    Ok(match message {
        CommandMessage::Twist => Actuation::Twist(wire::read_twist(payload)?),
        CommandMessage::TwistStamped => Actuation::Twist(wire::read_twist_stamped(payload)?.value),
        CommandMessage::Efforts { left_first, .. } => {
            let [first, second] = wire::read_two_numbers(payload)?;
            Actuation::Torque(if left_first {
                [second, first]
            } else {
                [first, second]
            })
        }
    })
}

/// The two numbers of a command.
fn pair(command: Actuation) -> [f64; 2] {
    let (Actuation::Twist(pair) | Actuation::Torque(pair)) = command;
    pair
}
