//! Position messages between robots, and round trips of a network.

use std::sync::Arc;

use super::streams::UnknownColumn;

/// Position messages between robots, in the order of sending.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// The messages.
    pub messages: Vec<LinkMessage>,
    /// Whether the messages contain velocities (`links.csv` has the columns).
    pub with_velocity: bool,
    /// Columns that the format does not define, kept as text.
    pub unknown: Vec<UnknownColumn>,
}

/// One position message.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkMessage {
    /// Time of sending (s).
    pub t_sent_s: f64,
    /// Time of arrival (s); `None` if the message was lost.
    pub t_received_s: Option<f64>,
    /// The sender.
    pub from: Arc<str>,
    /// The receiver.
    pub to: Arc<str>,
    /// Sent x (m). NaN if the cell is empty, as in all fields below.
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
    /// Sequence number of each round trip.
    pub seq: Vec<i64>,
    /// Duration of each round trip (ms), as long as `seq`; NaN if the cell is empty.
    pub rtt_ms: Vec<f64>,
    /// Columns that the format does not define, kept as text.
    pub unknown: Vec<UnknownColumn>,
}
