//! The process of a robot in a box: on the wall clock, behind topics.

use std::io::Write;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use slipstream_bus::transport::BusError;
use slipstream_bus::{Camera, InputError, RobotModel};
use slipstream_ipc::clock::{Monotonic, WallClock};
use slipstream_recording::wire;

use super::robot::BoxedRobot;
use crate::lab::{Lab, LabRobot, WheelTopic};
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
    /// Largest speed (m/s) and yaw rate (rad/s) that it was told.
    pub largest: [f64; 2],
    /// Largest change from one command to the next: speed (m/s) and yaw rate (rad/s).
    pub largest_step: [f64; 2],
    /// Its true pose at the end: x (m), y (m), yaw (rad) of c.
    pub final_pose: [f64; 3],
}

/// Plays the robot `robot` of a lab until `goes_on` says no. Every change of what it follows is a line of `log`: time of
/// the system's monotonic clock (ns), v (m/s), w (rad/s).
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
        published: std::iter::once(Topic::of_wheels(robot))
            .chain(Topic::of_pose(robot))
            .collect(),
        heard: vec![Topic::of_command(robot)],
    })?;
    run_over(topics, robot, options, log, goes_on)
}

/// As [`run`], over topics that are open: wheels and pose are published at places 0 and 1, commands are heard.
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
    let (pose, camera) = (options.pose, options.camera.clone());
    let own = BoxedRobot::new(
        &robot.name,
        options.model,
        pose,
        camera,
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
        followed: [0.0; 2],
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
    followed: [f64; 2],
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
        let is_axle = self.robot.pose.as_ref().is_some_and(|pose| pose.is_axle);
        let back = if is_axle {
            self.own.com_to_axle_m()
        } else {
            0.0
        };
        let mut poses = Vec::new();
        self.own
            .advance(now_ns, |t_ns, pose| poses.push((t_ns, pose)));
        for (t_ns, [x, y, yaw]) in poses {
            if self.robot.pose.is_some() {
                let pose = [x - back * yaw.cos(), y - back * yaw.sin(), yaw];
                let message = wire::pose(self.start_system_ns + t_ns, pose);
                self.topics.publish(1, message);
            }
        }
        if now_ns >= self.due_ns {
            self.due_ns = (now_ns / self.period_ns + 1) * self.period_ns;
            self.send_wheels();
        }
        self.log_change(now_ns, log)?;
        Ok(())
    }

    fn take(&mut self, payload: &[u8], now_ns: i64) {
        let read = match self.robot.command.is_stamped {
            true => wire::read_twist_stamped(payload).map(|own| own.value),
            false => wire::read_twist(payload),
        };
        let Ok(twist) = read else {
            self.report.unreadable += 1;
            return;
        };
        let before = self.own.followed(now_ns);
        for i in 0..2 {
            let [largest, step] = [
                &mut self.report.largest[i],
                &mut self.report.largest_step[i],
            ];
            *largest = largest.max(twist[i].abs());
            // A stop is allowed to be sudden.
            if twist != [0.0; 2] {
                *step = step.max((twist[i] - before[i]).abs());
            }
        }
        self.report.commands += 1;
        self.own.tell(twist, now_ns);
    }

    fn send_wheels(&mut self) {
        let stamp_ns = self.start_system_ns + self.own.time_ns();
        let message = match &self.robot.wheels {
            WheelTopic::Joints {
                joints: [right, left],
                ..
            } => wire::joint_angles(stamp_ns, [right, left], self.own.wheel_angles()),
            WheelTopic::Odometry { .. } => {
                wire::odometry(stamp_ns, &self.robot.name, self.own.odometry())
            }
        };
        self.topics.publish(0, message);
    }

    fn log_change(&mut self, now_ns: i64, log: &mut dyn Write) -> std::io::Result<()> {
        let followed = self.own.followed(now_ns);
        if followed != self.followed {
            self.followed = followed;
            let at_ns = self.start.plus_ns(now_ns).to_shared();
            let [v, w] = followed;
            writeln!(log, "{at_ns},{v},{w}")?;
        }
        Ok(())
    }
}
