//! The delays of a run's links as round trips (rtt.csv), to be replayed as link delay.

use std::fmt::Write as _;

use slipstream_bus::message::RobotIndex;

use crate::log::Log;
use crate::way::{Message, by_link, follow};

/// One link's messages as an rtt.csv.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoundTrips {
    /// The sender's index.
    pub from: RobotIndex,
    /// The receiver's index.
    pub to: RobotIndex,
    /// The file: each message's delay is half of its row; the row of a lost one is empty.
    pub csv: String,
}

/// The round trips that give each link's delays again, to the nanosecond, when they are replayed
/// with `links.delay_s=0`.
pub fn round_trips(log: &Log) -> Vec<RoundTrips> {
    // What never came to the link has no delay that could be replayed.
    let came = |message: &Message| log.arrived.contains_key(&(message.from, message.seq));
    let messages = follow(log).into_iter().filter(came);
    by_link(messages.map(|message| (message.link(), message)))
        .into_iter()
        .map(|((from, to), messages)| RoundTrips {
            from,
            to,
            csv: csv(&messages),
        })
        .collect()
}

/// Writing to a string cannot fail.
fn csv(messages: &[Message]) -> String {
    let mut text = "seq,rtt_ms\n".to_owned();
    for message in messages {
        let _ = match message.delay_ns {
            Some(delay_ns) => {
                let rtt_ns = delay_ns.max(0).unsigned_abs() * 2;
                let (ms, rest) = (rtt_ns / 1_000_000, rtt_ns % 1_000_000);
                writeln!(text, "{},{ms}.{rest:06}", message.seq)
            }
            None => writeln!(text, "{},", message.seq),
        };
    }
    text
}
