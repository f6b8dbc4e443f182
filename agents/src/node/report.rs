//! Report of an agent at the end of a run.

use serde::{Deserialize, Serialize};
use slipstream_bus::link::LinkCounts;
use slipstream_bus::message::RobotIndex;

/// What a node reports at the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct NodeReport {
    /// Final pose of c by odometry: x (m), y (m), φ (rad).
    pub final_odometry: [f64; 3],
    /// The largest desired speed before limiting (m/s).
    pub max_desired_speed_m_s: f64,
    /// Receiver of the outgoing link, and number of positions sent.
    pub sent: Option<(RobotIndex, u64)>,
    /// Sender of the incoming link, and counts of its messages.
    pub received: Option<(RobotIndex, LinkCounts)>,
}
