//! Records: what the processes of a run log for the recording, as plain values.
//!
//! Times are in ns since the start of the run; robots are named by index. The trace (`trace.rs`) is
//! recorded beside the records and holds the durations.

use serde::{Deserialize, Serialize};

use crate::message::{Actuation, Position, RobotIndex};

/// One entry of the log of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// True state of a robot.
    State(State),
    /// The encoders as read by a control tick.
    Encoders {
        /// When they were read (ns).
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// Signed cumulative counts.
        counts: [i64; 2],
    },
    /// What the plant applies from `t_ns` on.
    Applied {
        /// Begin of the plant step (ns).
        t_ns: i64,
        /// When the plant received it (ns): in virtual time at the begin of the step, on
        /// the wall clock when the end of the step is due.
        taken_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// The inner tick that commanded it (ns).
        tick_ns: i64,
        /// What was commanded.
        actuation: Actuation,
    },
    /// Wheel angles as a real robot sends them.
    WheelAngles {
        /// When they were measured (ns).
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// The angles (rad).
        angle_rad: [f64; 2],
    },
    /// Odometry as a real robot sends it.
    RobotOdometry {
        /// When it was measured (ns).
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// x (m), y (m), yaw (rad).
        pose: [f64; 3],
        /// v (m/s) and w (rad/s).
        velocity: [f64; 2],
    },
    /// A pose measured by the external camera.
    Camera {
        /// Time stamp of the camera (ns).
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// x (m), y (m), yaw (rad) of c.
        pose: [f64; 3],
    },
    /// A sample of accelerometer and gyro at c.
    Imu {
        /// Time stamp of the sensor (ns).
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// Specific force forward and to the left (m/s²).
        acceleration_m_s2: [f64; 2],
        /// Yaw rate (rad/s).
        yaw_rate_rad_s: f64,
    },
    /// An outer tick of a controller.
    Outer(OuterTick),
    /// An inner tick of a controller.
    Inner(InnerTick),
    /// A position was sent.
    Sent {
        /// The receiver.
        to: RobotIndex,
        /// The message.
        position: Position,
    },
    /// A position entered the receiver's delay line.
    Arrived {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Sequence number of the message.
        seq: u32,
        /// When it was sent (ns).
        sent_ns: i64,
        /// When it leaves the delay line (ns); `None` if it is lost.
        available_ns: Option<i64>,
    },
    /// A position left the delay line at an outer tick.
    Taken {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Sequence number of the message.
        seq: u32,
        /// The receiver's outer tick (ns).
        tick_ns: i64,
        /// What the receiver did with it.
        fate: Fate,
    },
    /// Any other event.
    Event {
        /// When it happened (ns).
        t_ns: i64,
        /// The robot, if the event concerns one.
        robot: Option<RobotIndex>,
        /// What happened.
        kind: EventKind,
    },
}

/// What the receiver did with a position that left the delay line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fate {
    /// It became the reference at this tick.
    Used,
    /// A newer one left the delay line at the same tick.
    Superseded,
    /// A newer one had been delivered before.
    Stale,
    /// It was delivered after the last outer tick.
    Unused,
}

impl Fate {
    /// All variants with their names in the trace.
    const NAMES: [(Self, &'static str); 4] = [
        (Self::Used, "used"),
        (Self::Superseded, "superseded"),
        (Self::Stale, "stale"),
        (Self::Unused, "unused"),
    ];

    /// Its name in the trace.
    pub fn name(self) -> &'static str {
        let found = Self::NAMES.iter().find(|(fate, _)| *fate == self);
        found.map_or("", |(_, name)| name)
    }

    /// The variant with this name in the trace.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = Self::NAMES.iter().find(|(_, other)| *other == name);
        found.map(|(fate, _)| *fate)
    }
}

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventKind {
    /// A follower's watchdog fired: no fresh position arrived in time, it brakes.
    WatchdogFired,
    /// A fresh position arrived again.
    WatchdogCleared,
    /// The front robot started a new token round, because the last one did not return in time.
    RingRestarted,
    /// The encoder readings of a controller are too old: it commands no torque.
    PlantLost,
    /// Fresh encoder readings arrive again.
    PlantBack,
    /// A tick was skipped on the wall clock, because the one before it took too long.
    DeadlineMissed,
    /// A real robot is not heard: it is told to stand.
    RobotLost,
    /// The agent of a real robot is silent: the robot is told to stand.
    AgentSilent,
    /// A real robot that was told to stand drives again.
    RobotBack,
    /// The process died.
    Died,
    /// A restarted agent joined the run.
    Rejoined,
}

impl EventKind {
    /// Description for people, as it stands in recordings.
    pub fn description(self) -> &'static str {
        match self {
            Self::WatchdogFired => "no fresh position: slows down",
            Self::WatchdogCleared => "has a fresh position again",
            Self::RingRestarted => "the ring was silent: started anew",
            Self::PlantLost => "the encoders went silent: no torque",
            Self::PlantBack => "the encoders are back",
            Self::DeadlineMissed => "a deadline was missed",
            Self::RobotLost => "is not heard: told to stand",
            Self::AgentSilent => "its agent is silent: told to stand",
            Self::RobotBack => "drives again",
            Self::Died => "died",
            Self::Rejoined => "came back",
        }
    }
}

/// True state of one robot after a plant step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// Time of the state (ns).
    pub t_ns: i64,
    /// The robot.
    pub robot: RobotIndex,
    /// x (m), y (m), φ (rad) of c.
    pub pose: [f64; 3],
    /// Velocity of c in the body frame (m/s, m/s) and yaw rate (rad/s).
    pub velocity: [f64; 3],
    /// Wheel angles (rad).
    pub wheel_angle_rad: [f64; 2],
    /// Wheel speeds (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// Applied torques (N m).
    pub torque_nm: [f64; 2],
    /// Normal forces (N).
    pub normal_n: [f64; 2],
    /// Slip velocities: along the right wheel, along the left wheel, lateral (m/s).
    pub slip_m_s: [f64; 3],
    /// Whether the contact of each wheel slides.
    pub slides: [bool; 2],
}

/// An outer tick of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct OuterTick {
    /// When it was due (ns).
    pub t_ns: i64,
    /// When the encoders were read (ns).
    pub sampled_ns: i64,
    /// The robot.
    pub robot: RobotIndex,
    /// x (m), y (m), φ (rad) of c by odometry.
    pub pose: [f64; 3],
    /// v (m/s) and w (rad/s) from the wheel speeds.
    pub velocity: [f64; 2],
    /// Reference x (m), y (m), φ (rad) of c.
    pub reference: [f64; 3],
    /// v_r (m/s) and w_r (rad/s).
    pub reference_velocity: [f64; 2],
    /// e_x (m), e_y (m), e_θ (rad).
    pub error: [f64; 3],
    /// v_d (m/s) and w_d (rad/s) before limiting.
    pub desired: [f64; 2],
    /// Wheel speed set-points for the inner loop (rad/s).
    pub set_point_rad_s: [f64; 2],
    /// Sequence number of the message behind the reference.
    pub message: Option<u32>,
}

/// An inner tick of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct InnerTick {
    /// When it was due (ns).
    pub t_ns: i64,
    /// When the encoders were read (ns).
    pub sampled_ns: i64,
    /// The robot.
    pub robot: RobotIndex,
    /// The outer tick that computed the set-points (ns).
    pub outer_ns: i64,
    /// Mean wheel speeds since the last inner tick (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// Torques before limiting (N m).
    pub wanted_nm: [f64; 2],
    /// Torque limits (N m).
    pub limit_nm: [f64; 2],
    /// Commanded torques (N m).
    pub torque_nm: [f64; 2],
    /// Friction coefficient behind the limits (1) and its standard deviation, if estimated.
    pub friction: [f64; 2],
}

/// Receives the log of a run.
pub trait Recorder {
    /// Logs one record. A recorder counts what it cannot keep and reports the count at the end, so
    /// that a control loop never stops for it.
    fn record(&mut self, record: &Record);

    /// Logs a chunk of the trace (`trace.rs`) whose first record happened at `t_ns`.
    fn trace(&mut self, _t_ns: i64, _bytes: &[u8]) {}
}

/// A recorder that discards everything.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoRecorder;

impl Recorder for NoRecorder {
    fn record(&mut self, _: &Record) {}
}

impl Recorder for Vec<Record> {
    fn record(&mut self, record: &Record) {
        self.push(*record);
    }
}

impl Record {
    /// When it happened (ns); for `Sent` and `Arrived` the time of sending.
    pub fn t_ns(&self) -> i64 {
        match *self {
            Self::State(State { t_ns, .. })
            | Self::Encoders { t_ns, .. }
            | Self::Applied { t_ns, .. }
            | Self::WheelAngles { t_ns, .. }
            | Self::RobotOdometry { t_ns, .. }
            | Self::Camera { t_ns, .. }
            | Self::Imu { t_ns, .. }
            | Self::Outer(OuterTick { t_ns, .. })
            | Self::Inner(InnerTick { t_ns, .. })
            | Self::Event { t_ns, .. }
            | Self::Taken { tick_ns: t_ns, .. } => t_ns,
            Self::Sent { position, .. } => position.sent_ns,
            Self::Arrived { sent_ns, .. } => sent_ns,
        }
    }
}
