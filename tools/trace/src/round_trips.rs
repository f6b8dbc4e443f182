//! The delays of a run's links as round-trip times (`rtt.csv`), to be replayed with `links.trace`.

use std::fmt::Write as _;

use slipstream_bus::message::RobotIndex;

use crate::chain::{TracedMessage, by_link, messages};
use crate::log::Log;

/// One link's messages as an rtt.csv.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RoundTrips {
    /// The sender's index.
    pub from: RobotIndex,
    /// The receiver's index.
    pub to: RobotIndex,
    /// Content of the file: each message's delay is half of its `rtt_ms`, which is empty for a lost
    /// message.
    pub csv: String,
}

/// Round-trip times that reproduce each link's delays to the nanosecond when they are replayed with
/// `links.delay_s=0`.
pub fn round_trips(log: &Log) -> Vec<RoundTrips> {
    // A message that never reached the link has no delay to replay.
    let arrived = |message: &TracedMessage| {
        log.arrived((message.from, message.to, message.seq))
            .is_some()
    };
    let messages = messages(log).filter(arrived);
    by_link(messages.map(|message| (message.link(), message)))
        .into_iter()
        .map(|((from, to), messages)| RoundTrips {
            from,
            to,
            csv: csv(&messages),
        })
        .collect()
}

fn csv(messages: &[TracedMessage]) -> String {
    let mut text = "seq,rtt_ms\n".to_owned();
    for message in messages {
        // Writing to a string cannot fail.
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
