//! Report of an agent at the end of a run.

use serde::{Deserialize, Serialize};
use slipstream_bus::link::LinkCounts;
use slipstream_bus::message::RobotIndex;

/// What a node reports at the end of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct NodeReport {
    /// Final pose of c by odometry: x (m), y (m), φ (rad).
    pub final_odometry: [f64; 3],
    /// The largest desired speed before limiting (m/s).
    pub max_desired_speed_m_s: f64,
    /// Receivers of the outgoing links, and number of positions sent to each.
    pub sent: Vec<(RobotIndex, u64)>,
    /// Senders of the incoming links, and counts of their messages.
    pub received: Vec<(RobotIndex, LinkCounts)>,
}
