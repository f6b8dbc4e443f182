//! What crosses the bus: fixed layouts, values only, times in nanoseconds since the run began.
//!
//! The name of each type carries the version of its layout: two programs that disagree do not
//! connect. Pairs are always [right, left].

use iceoryx2::prelude::ZeroCopySend;
use serde::{Deserialize, Serialize};

/// A robot in a run: 0 is the front one, `r1`.
pub type RobotIndex = u32;

/// The name of robot `index`: `r1` for 0.
pub fn robot_name(index: RobotIndex) -> String {
    format!("r{}", index + 1)
}

/// The state of one robot's encoders, plant → agent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("slipstream.Encoders.1")]
#[repr(C)]
pub struct Encoders {
    /// When the counters were read (ns).
    pub sampled_ns: i64,
    /// Signed cumulative counts.
    pub counts: [i64; 2],
}

/// The header of a sample of all robots' encoders.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("slipstream.WorldHeader.1")]
#[repr(C)]
pub struct WorldHeader {
    /// The instant of the sample (ns).
    pub now_ns: i64,
    /// The round of the barrier that the sample belongs to; 0 on the wall clock.
    pub epoch: u32,
    /// Keeps the layout free of holes.
    pub reserved: u32,
}

/// What an agent tells its robot's drives, agent → plant.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("slipstream.Torque.1")]
#[repr(C)]
pub struct TorqueCommand {
    /// The robot.
    pub robot: RobotIndex,
    /// The round that this answers; 0 on the wall clock.
    pub epoch: u32,
    /// The inner tick that computed it (ns).
    pub tick_ns: i64,
    /// Torque at each wheel (N m).
    pub torque_nm: [f64; 2],
}

/// Where a robot believes to be, robot → the next one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ZeroCopySend)]
#[type_name("slipstream.Position.1")]
#[repr(C)]
pub struct Position {
    /// The sender.
    pub from: RobotIndex,
    /// Counts the sender's messages from 0.
    pub seq: u32,
    /// Counts the front robot's turns around the ring from 0.
    pub turn: u32,
    /// Keeps the layout free of holes.
    pub reserved: u32,
    /// When the encoders behind it were read (ns).
    pub sampled_ns: i64,
    /// The sender's outer tick (ns).
    pub tick_ns: i64,
    /// When it was handed to the bus (ns).
    pub sent_ns: i64,
    /// x of c (m), by odometry.
    pub x_m: f64,
    /// y of c (m).
    pub y_m: f64,
    /// Heading φ, not wrapped (rad).
    pub yaw_rad: f64,
    /// v_r: the sender's reference speed (m/s).
    pub v_m_s: f64,
    /// w_r: the sender's reference yaw rate (rad/s).
    pub w_rad_s: f64,
}
