//! Runs across several hosts, in lockstep on virtual time.
//!
//! On the plant's host one process, the [`stand_in`], takes the part of every agent that runs elsewhere. On each other
//! host one process, the [`relay`], takes the part of the plant. Between the two go one [`frame`] down and one up in
//! every round of the lockstep, over a [`carrier`]. Controllers, plant and recorder do not know of any of this.
//!
//! A position that is sent in one round is needed in the next at the earliest, so positions travel with the rounds.
//! A frame that is lost is sent again, and a round that comes twice is answered from memory: a cut of the network that
//! is shorter than `host_timeout_s` changes nothing but the wall time.

pub mod address;
pub mod carrier;
pub mod frame;
pub mod hello;
pub mod network;
pub mod relay;
pub mod stand_in;
mod timing;
