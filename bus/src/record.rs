//! What the processes of a run tell the recorder: plain values, times in ns since the run began.
//!
//! Each record names its robot by index. How long everything took is told by the trace beside them
//! (`trace.rs`).

use serde::{Deserialize, Serialize};

use crate::message::{Position, RobotIndex};

/// One thing that happened.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// The truth about a robot.
    State(State),
    /// The encoders as a tick read them.
    Encoders {
        /// When they were read.
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// Signed cumulative counts.
        counts: [i64; 2],
    },
    /// The torque that the plant applies from `t_ns` on.
    Applied {
        /// The plant step's begin.
        t_ns: i64,
        /// When the plant took the torque up. On the wall clock that is when the step's end is due,
        /// in virtual time its begin.
        taken_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// The inner tick that asked for it.
        tick_ns: i64,
        /// The torque as commanded (N m).
        torque_nm: [f64; 2],
    },
    /// The camera above saw a robot.
    Camera {
        /// The stamp that the camera gives.
        t_ns: i64,
        /// The robot.
        robot: RobotIndex,
        /// x (m), y (m), yaw (rad) of c.
        pose: [f64; 3],
    },
    /// Accelerometer and gyro at c.
    Imu {
        /// The stamp that the sensor gives.
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
    /// A position went out.
    Sent {
        /// The receiver.
        to: RobotIndex,
        /// The message.
        position: Position,
    },
    /// A position came to the receiver's delay line.
    Arrived {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// The message's number.
        seq: u32,
        /// When it was sent.
        sent_ns: i64,
        /// When the line gives it out; `None`: it is lost.
        available_ns: Option<i64>,
    },
    /// A position left the delay line at an outer tick.
    Taken {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// The message's number.
        seq: u32,
        /// The receiver's outer tick.
        tick_ns: i64,
        /// What became of it.
        fate: Fate,
    },
    /// Something else worth knowing.
    Event {
        /// When.
        t_ns: i64,
        /// Whom it concerns, if one robot.
        robot: Option<RobotIndex>,
        /// What.
        kind: EventKind,
    },
}

/// What became of a position that left the delay line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fate {
    /// It is the reference from this tick on.
    Used,
    /// A newer one left the line at the same tick.
    Superseded,
    /// A newer one had come before.
    Stale,
    /// It came after the last outer tick.
    Unused,
}

impl Fate {
    /// All with their names in the trace.
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

    /// The fate of a name.
    pub fn named(name: &str) -> Option<Self> {
        let found = Self::NAMES.iter().find(|(_, other)| *other == name);
        found.map(|(fate, _)| *fate)
    }
}

/// Something worth knowing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventKind {
    /// A follower had no fresh position and slows down.
    WatchdogFired,
    /// It has one again.
    WatchdogCleared,
    /// The front robot started the ring anew.
    RingRestarted,
    /// The encoders went silent: no torque.
    PlantLost,
    /// They are back.
    PlantBack,
    /// A loop was too late on the wall clock.
    DeadlineMissed,
    /// Its process died.
    Died,
    /// A dead agent came back.
    Rejoined,
}

impl EventKind {
    /// What happened, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::WatchdogFired => "no fresh position: slows down",
            Self::WatchdogCleared => "has a fresh position again",
            Self::RingRestarted => "the ring was silent: started anew",
            Self::PlantLost => "the encoders went silent: no torque",
            Self::PlantBack => "the encoders are back",
            Self::DeadlineMissed => "a deadline was missed",
            Self::Died => "died",
            Self::Rejoined => "came back",
        }
    }
}

/// The truth about one robot after a plant step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// When.
    pub t_ns: i64,
    /// The robot.
    pub robot: RobotIndex,
    /// x (m), y (m), φ (rad) of c.
    pub pose: [f64; 3],
    /// Velocity of c in the body's axes (m/s, m/s) and the yaw rate (rad/s).
    pub velocity: [f64; 3],
    /// Wheel angles (rad).
    pub wheel_angle_rad: [f64; 2],
    /// Wheel speeds (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// Applied torques (N m).
    pub torque_nm: [f64; 2],
    /// Normal forces (N).
    pub normal_n: [f64; 2],
    /// Sliding speeds at the contacts: along the right and the left wheel, across both (m/s).
    pub slip_m_s: [f64; 3],
    /// Whether each contact slides.
    pub slides: [bool; 2],
}

/// An outer tick of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct OuterTick {
    /// When it was due.
    pub t_ns: i64,
    /// When the encoders behind it were read.
    pub sampled_ns: i64,
    /// The robot.
    pub robot: RobotIndex,
    /// x (m), y (m), φ (rad) of c by odometry.
    pub pose: [f64; 3],
    /// v (m/s) and w (rad/s) by the wheels.
    pub velocity: [f64; 2],
    /// The reference's x (m), y (m), φ (rad) of c.
    pub reference: [f64; 3],
    /// v_r (m/s) and w_r (rad/s).
    pub reference_velocity: [f64; 2],
    /// e_x (m), e_y (m), e_θ (rad).
    pub error: [f64; 3],
    /// v_d (m/s) and w_d (rad/s) before limiting.
    pub desired: [f64; 2],
    /// Wheel speeds asked of the inner loop (rad/s).
    pub set_point_rad_s: [f64; 2],
    /// The number of the message that the reference comes from.
    pub message: Option<u32>,
}

/// An inner tick of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct InnerTick {
    /// When it was due.
    pub t_ns: i64,
    /// When the encoders behind it were read.
    pub sampled_ns: i64,
    /// The robot.
    pub robot: RobotIndex,
    /// The outer tick whose set-points it obeys.
    pub outer_ns: i64,
    /// Wheel speeds since the last inner tick (rad/s).
    pub wheel_speed_rad_s: [f64; 2],
    /// What the loops asked for before limiting (N m).
    pub wanted_nm: [f64; 2],
    /// The limits in force (N m).
    pub limit_nm: [f64; 2],
    /// The torque commanded (N m).
    pub torque_nm: [f64; 2],
    /// The friction that the limit supposes (1), and its standard deviation where estimated.
    pub friction: [f64; 2],
}

/// Takes records.
pub trait Recorder {
    /// Takes one record. What cannot be kept is for the recorder to report at its end: a loop does
    /// not stop for it.
    fn record(&mut self, record: &Record);

    /// Takes a piece of the trace (`trace.rs`), whose first record is of the instant `t_ns`.
    fn trace(&mut self, _t_ns: i64, _bytes: &[u8]) {}
}

/// Keeps nothing.
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
    /// When it happened (ns).
    pub fn t_ns(&self) -> i64 {
        match *self {
            Self::State(State { t_ns, .. })
            | Self::Encoders { t_ns, .. }
            | Self::Applied { t_ns, .. }
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
