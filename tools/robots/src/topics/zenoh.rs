//! Topics over Zenoh.

use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use slipstream_bus::transport::BusError;
use slipstream_hosts::network::{Ends, open_session};
use slipstream_ipc::clock::Monotonic;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use super::carrier::{Heard, Opening, Topics};
use super::names::{Topic, attachment};
use crate::lab::Wire;
use crate::system_clock::system_ns;

/// Largest message that is taken from the network (bytes): a joint state with a hundred joints has ten thousand.
const MAX_BYTES: usize = 64 << 10;

/// Opens topics.
///
/// # Errors
/// It cannot be listened at an address, or the certificates cannot be used. An address to which it cannot be connected
/// is tried again until it can.
pub fn open(opening: &Opening<'_>) -> Result<Box<dyn Topics>, BusError> {
    let session = open_session(&Ends {
        connect: &opening.connect,
        listen: &opening.listen,
        security: opening.security,
    });
    let session = session.map_err(|error| failed(&error))?;
    let (sender, messages) = channel();
    for (place, topic) in opening.heard.iter().enumerate() {
        let sender = sender.clone();
        let heard = move |sample: Sample| {
            let arrived = Monotonic::now();
            let payload = sample.payload();
            if payload.len() <= MAX_BYTES {
                let payload = payload.to_bytes().into_owned();
                // The receiver may have ended.
                let _ = sender.send(Heard {
                    place,
                    payload,
                    arrived,
                });
            }
        };
        let subscriber = session.declare_subscriber(topic.heard_key(opening.wire));
        subscriber
            .callback(heard)
            .background()
            .wait()
            .map_err(|error| failed(&error))?;
    }
    let publish = |topic: &Topic| {
        let publisher = session
            .declare_publisher(topic.key(opening.wire))
            .express(true)
            .priority(Priority::RealTime)
            // A command that waits is an old command.
            .congestion_control(CongestionControl::Drop);
        publisher.wait()
    };
    let publishers = opening.published.iter().map(publish);
    let publishers: Result<Vec<_>, _> = publishers.collect();
    let mut identifier = [0; 16];
    let own = session.zid().to_le_bytes();
    identifier.copy_from_slice(&own);
    Ok(Box::new(Network {
        publishers: publishers.map_err(|error| failed(&error))?,
        attaches: opening.wire != Wire::Ros2dds,
        identifier,
        number: 0,
        messages,
        _session: session,
    }))
}

fn failed(error: &impl std::fmt::Display) -> BusError {
    BusError::Failed {
        what: "network".to_owned(),
        reason: error.to_string(),
    }
}

struct Network {
    publishers: Vec<Publisher<'static>>,
    /// Whether messages have an attachment.
    attaches: bool,
    identifier: [u8; 16],
    number: i64,
    messages: Receiver<Heard>,
    _session: Session,
}

impl Topics for Network {
    fn publish(&mut self, place: usize, payload: Vec<u8>) {
        let Some(publisher) = self.publishers.get(place) else {
            return;
        };
        self.number += 1;
        let mut put = publisher.put(payload);
        if self.attaches {
            // Each topic has a publisher of its own.
            let mut identifier = self.identifier;
            identifier[15] ^= place as u8;
            put = put.attachment(attachment(self.number, system_ns(), identifier));
        }
        // Where nobody listens there is nothing to do: silence of a robot is noticed by what is heard of it.
        let _ = put.wait();
    }

    fn receive(&mut self, timeout: Duration) -> Option<Heard> {
        self.messages.recv_timeout(timeout).ok()
    }
}
