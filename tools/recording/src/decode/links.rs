//! Position messages and round trips assembled from messages that arrive one by one.

use crate::bag::{Undecodable, VisitResult};
use crate::recording::{LinkMessage, Links, NamePool, RoundTrips, UnknownColumn};
use crate::ros2::cdr::decode;
use crate::ros2::messages as ros;
use crate::ros2::time::s_from_ns;
use crate::table::finite_or_nan;

/// Position messages being collected.
#[derive(Debug, Default)]
pub(crate) struct LinksBuilder {
    links: Links,
    names: NamePool,
}

impl LinksBuilder {
    /// No messages yet, with these unknown columns.
    pub(crate) fn new(with_velocity: bool, unknown: &[String]) -> Self {
        Self {
            links: Links {
                messages: Vec::new(),
                with_velocity,
                unknown: empty_columns(unknown),
            },
            names: NamePool::default(),
        }
    }

    /// Appends a position message.
    pub(crate) fn push_message(&mut self, data: &[u8]) -> VisitResult {
        let message: ros::PositionMessage<String> = decode(data).map_err(|_| Undecodable)?;
        let arrived = message.fate == 0;
        self.links.messages.push(LinkMessage {
            t_sent_s: s_from_ns(message.t_sent_ns),
            t_received_s: arrived.then(|| s_from_ns(message.t_received_ns)),
            from: self.names.get(&message.sender),
            to: self.names.get(&message.receiver),
            x_m: finite_or_nan(message.x_m),
            y_m: finite_or_nan(message.y_m),
            yaw_rad: finite_or_nan(message.yaw_rad),
            v_m_s: finite_or_nan(message.v_m_s),
            w_rad_s: finite_or_nan(message.w_rad_s),
        });
        Ok(())
    }

    /// Appends a message from a lossless row.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> VisitResult {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let [received, x_m, y_m, yaw_rad, v_m_s, w_rad_s] = row.numbers[..] else {
            return Err(Undecodable);
        };
        let mut texts = row.texts.into_iter();
        let (Some(from), Some(to)) = (texts.next(), texts.next()) else {
            return Err(Undecodable);
        };
        if !row.t_s.is_finite() || texts.len() != self.links.unknown.len() {
            return Err(Undecodable);
        }
        self.links.messages.push(LinkMessage {
            t_sent_s: row.t_s,
            t_received_s: Some(received).filter(|t_s| t_s.is_finite()),
            from: self.names.get(&from),
            to: self.names.get(&to),
            x_m,
            y_m,
            yaw_rad,
            v_m_s,
            w_rad_s,
        });
        for (column, cell) in self.links.unknown.iter_mut().zip(texts) {
            column.cells.push(cell);
        }
        Ok(())
    }

    /// The messages in the order of sending. (A run writes a message once its delivery status is
    /// known.)
    pub(crate) fn finish(mut self) -> Links {
        let sent = |message: &LinkMessage| message.t_sent_s;
        if !self.links.messages.is_sorted_by_key(sent) && self.links.unknown.is_empty() {
            let messages = &mut self.links.messages;
            messages.sort_by(|a, b| a.t_sent_s.total_cmp(&b.t_sent_s));
        }
        self.links
    }
}

/// Round trips being collected.
#[derive(Debug, Default)]
pub(crate) struct RoundTripsBuilder(RoundTrips);

impl RoundTripsBuilder {
    /// No round trips yet, with these unknown columns.
    pub(crate) fn new(unknown: &[String]) -> Self {
        Self(RoundTrips {
            unknown: empty_columns(unknown),
            ..RoundTrips::default()
        })
    }

    /// Appends a round trip.
    pub(crate) fn push_message(&mut self, data: &[u8]) -> VisitResult {
        let trip: ros::RoundTrip = decode(data).map_err(|_| Undecodable)?;
        self.0.seq.push(trip.seq);
        self.0.rtt_ms.push(finite_or_nan(trip.rtt_ms));
        Ok(())
    }

    /// Appends a round trip from a lossless row.
    pub(crate) fn push_row(&mut self, data: &[u8]) -> VisitResult {
        let row: ros::Row<Vec<f64>, Vec<String>> = decode(data).map_err(|_| Undecodable)?;
        let mut texts = row.texts.into_iter();
        let seq = texts.next().and_then(|text| text.parse().ok());
        let (Some(seq), &[rtt_ms]) = (seq, row.numbers.as_slice()) else {
            return Err(Undecodable);
        };
        if texts.len() != self.0.unknown.len() {
            return Err(Undecodable);
        }
        self.0.seq.push(seq);
        self.0.rtt_ms.push(finite_or_nan(rtt_ms));
        for (column, cell) in self.0.unknown.iter_mut().zip(texts) {
            column.cells.push(cell);
        }
        Ok(())
    }

    /// The round trips in file order.
    pub(crate) fn finish(self) -> RoundTrips {
        self.0
    }
}

fn empty_columns(names: &[String]) -> Vec<UnknownColumn> {
    names.iter().map(UnknownColumn::named).collect()
}
