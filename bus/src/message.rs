//! Messages between plant and agents: plain values, times in nanoseconds since the run began.
//!
//! Pairs are always [right, left]. How a transport lays them out in memory is its own affair.

use serde::{Deserialize, Serialize};

/// A robot in a run: 0 is the front one, `r1`.
pub type RobotIndex = u32;

/// The name of robot `index`: `r1` for 0.
pub fn robot_name(index: RobotIndex) -> String {
    format!("r{}", index + 1)
}

/// The state of one robot's encoders, plant → agent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Encoders {
    /// When the counters were read (ns).
    pub sampled_ns: i64,
    /// Signed cumulative counts.
    pub counts: [i64; 2],
}

/// What an agent tells its robot's drives, agent → plant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
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
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// The sender.
    pub from: RobotIndex,
    /// Counts the sender's messages from 0.
    pub seq: u32,
    /// Counts the front robot's turns around the ring from 0.
    pub ring_round: u32,
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
