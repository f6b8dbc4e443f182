//! Messages between robots, and round trips of a network.

use std::sync::Arc;

use super::streams::UnknownColumn;

/// Position messages from robot to robot, in the order in which they were sent.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// The messages.
    pub messages: Vec<LinkMessage>,
    /// Whether the velocities were sent along (the columns are there).
    pub with_velocity: bool,
    /// Columns that the format does not know, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

/// One position message.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkMessage {
    /// When it was sent (s).
    pub t_sent_s: f64,
    /// When it arrived (s); `None`: it was lost.
    pub t_received_s: Option<f64>,
    /// The sender.
    pub from: Arc<str>,
    /// The receiver.
    pub to: Arc<str>,
    /// Sent x (m); NaN where empty, as in all that follow.
    pub x_m: f64,
    /// Sent y (m).
    pub y_m: f64,
    /// Sent heading (rad).
    pub yaw_rad: f64,
    /// Sent forward speed (m/s).
    pub v_m_s: f64,
    /// Sent yaw rate (rad/s).
    pub w_rad_s: f64,
}

/// Measured round trips of a network, in the order of measurement.
#[derive(Debug, Clone, Default)]
pub struct RoundTrips {
    /// The sequence number of each.
    pub seq: Vec<i64>,
    /// Its round trip (ms); NaN where empty.
    pub rtt_ms: Vec<f64>,
    /// Columns that the format does not know, kept as text.
    pub unknown: Vec<UnknownColumn>,
}
