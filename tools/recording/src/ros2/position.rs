//! A position message between robots: as plain data, and as a ROS message.

use super::compose::{WORLD, header};
use super::messages as ros;

/// What became of a position message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It arrived.
    Arrived {
        /// When (ns).
        t_received_ns: i64,
    },
    /// It was lost on the way.
    Lost,
    /// The run ended before it arrived.
    InFlight,
}

/// A position that one robot sent to another; known by sender and `seq`.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionRecord<'a> {
    /// The sender's name.
    pub sender: &'a str,
    /// The receiver's name.
    pub receiver: &'a str,
    /// Counts the sender's messages.
    pub seq: u64,
    /// When the encoders behind it were read (ns).
    pub t_sampled_ns: i64,
    /// When it was sent (ns).
    pub t_sent_ns: i64,
    /// What became of it.
    pub fate: Fate,
    /// Position (m, m) and heading (rad) as sent.
    pub pose: [f64; 3],
    /// Forward speed (m/s) and yaw rate (rad/s), where sent.
    pub velocity: Option<[f64; 2]>,
}

/// The message of a position record.
pub(crate) fn position_message<'a>(record: &PositionRecord<'a>) -> ros::PositionMessage<&'a str> {
    let (fate, t_received_ns) = match record.fate {
        Fate::Arrived { t_received_ns } => (0, t_received_ns),
        Fate::Lost => (1, 0),
        Fate::InFlight => (2, 0),
    };
    let [x_m, y_m, yaw_rad] = record.pose;
    let [v_m_s, w_rad_s] = record.velocity.unwrap_or([f64::NAN; 2]);
    ros::PositionMessage {
        header: header(record.t_sent_ns, WORLD),
        sender: record.sender,
        receiver: record.receiver,
        seq: record.seq,
        t_sampled_ns: record.t_sampled_ns,
        t_sent_ns: record.t_sent_ns,
        t_received_ns,
        fate,
        x_m,
        y_m,
        yaw_rad,
        v_m_s,
        w_rad_s,
    }
}
