//! What carries topics, and what it is opened with.

use std::time::Duration;

use slipstream_hosts::address::{Address, Security};
use slipstream_ipc::clock::Monotonic;

use super::names::Topic;
use crate::lab::Wire;

/// Published and heard topics.
pub trait Topics {
    /// Publishes a message on the topic at this place of the list. It never waits: what cannot leave at once is dropped.
    fn publish(&mut self, place: usize, payload: Vec<u8>);

    /// The next message, if there is one within `timeout`.
    fn receive(&mut self, timeout: Duration) -> Option<Heard>;
}

/// A message that was heard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Heard {
    /// The place of its topic in the list of heard topics.
    pub place: usize,
    /// The message, CDR.
    pub payload: Vec<u8>,
    /// When it came out of the network.
    pub arrived: Monotonic,
}

/// What is opened: where, how, and which topics.
#[derive(Debug, Clone)]
pub struct Opening<'a> {
    /// Addresses to connect to.
    pub connect: Vec<&'a Address>,
    /// Addresses to listen at.
    pub listen: Vec<&'a Address>,
    /// How the connections are protected.
    pub security: &'a Security,
    /// How topics are named.
    pub wire: Wire,
    /// Topics to publish.
    pub published: Vec<Topic>,
    /// Topics to hear.
    pub heard: Vec<Topic>,
}
