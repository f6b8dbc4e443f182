//! Messages between plant and agents, as plain values. Times are in ns since the start of the run.
//!
//! Pairs are always [right, left]. The memory layout is up to the transport.

use serde::{Deserialize, Serialize};

/// Index of a robot in a run; 0 is the front robot, `r1`.
pub type RobotIndex = u32;

/// The name of robot `index`: `r1` for 0.
pub fn robot_name(index: RobotIndex) -> String {
    format!("r{}", index + 1)
}

/// Encoder reading of one robot, plant → agent.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Encoders {
    /// When the counters were read (ns).
    pub sampled_ns: i64,
    /// Signed cumulative counts.
    pub counts: [i64; 2],
}

/// Wheel torques commanded by one controller, agent → plant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct TorqueCommand {
    /// The robot.
    pub robot: RobotIndex,
    /// The lockstep round that this answers; 0 on the wall clock.
    pub epoch: u32,
    /// The inner tick that computed the torques (ns).
    pub tick_ns: i64,
    /// Torque at each wheel (N m).
    pub torque_nm: [f64; 2],
}

/// Estimated position and reference velocity of a robot, robot → its successor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// The sender.
    pub from: RobotIndex,
    /// Sequence number of the sender's messages, from 0.
    pub seq: u32,
    /// Number of the token round of the ring protocol, from 0; always 0 for `periodic`.
    pub token_round: u32,
    /// When the encoders behind the estimate were read (ns).
    pub sampled_ns: i64,
    /// The sender's outer tick (ns).
    pub tick_ns: i64,
    /// When the transport sent it (ns).
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
