//! Position message between robots: as plain data, and as its ROS 2 message.

use slipstream_bag::ros::compose::{WORLD, header};
use slipstream_bag::ros::messages as ros;

/// Delivery status of a position message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It arrived.
    Arrived {
        /// Time of arrival (ns).
        t_received_ns: i64,
    },
    /// It was lost.
    Lost,
    /// It was still on its way when the run ended.
    InFlight,
}

/// A position message from one robot to another, identified by sender and `seq`.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionRecord<'a> {
    /// Name of the sender.
    pub sender: &'a str,
    /// Name of the receiver.
    pub receiver: &'a str,
    /// Sequence number of the sender's messages.
    pub seq: u64,
    /// Time at which the encoders behind the position were sampled (ns).
    pub t_sampled_ns: i64,
    /// Time of sending (ns).
    pub t_sent_ns: i64,
    /// Delivery status.
    pub fate: Fate,
    /// Sent x (m), y (m) and heading (rad).
    pub pose: [f64; 3],
    /// Sent forward speed (m/s) and yaw rate (rad/s); `None` if not sent.
    pub velocity: Option<[f64; 2]>,
    /// Numbers that the sender's controller adds.
    pub extra: &'a [f64],
}

impl<'a> PositionRecord<'a> {
    /// The ROS 2 message of this record.
    pub(crate) fn message(&self) -> ros::WrittenPosition<'a> {
        let (fate, t_received_ns) = match self.fate {
            Fate::Arrived { t_received_ns } => (0, t_received_ns),
            Fate::Lost => (1, 0),
            Fate::InFlight => (2, 0),
        };
        let [x_m, y_m, yaw_rad] = self.pose;
        let [v_m_s, w_rad_s] = self.velocity.unwrap_or([f64::NAN; 2]);
        let position = ros::PositionMessage {
            header: header(self.t_sent_ns, WORLD),
            sender: self.sender,
            receiver: self.receiver,
            seq: self.seq,
            t_sampled_ns: self.t_sampled_ns,
            t_sent_ns: self.t_sent_ns,
            t_received_ns,
            fate,
            x_m,
            y_m,
            yaw_rad,
            v_m_s,
            w_rad_s,
        };
        let extra = self.extra;
        ros::WrittenPosition { position, extra }
    }
}
