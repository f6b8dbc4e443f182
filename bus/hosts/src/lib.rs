//! Runs across several hosts.
//!
//! On the plant's host one process, the [`stand_in`], takes the part of every agent that runs elsewhere. On each other
//! host one process, the [`relay`], takes the part of the plant. Between the two go [`frame`]s over a [`carrier`].
//! Controllers, plant and recorder do not know of any of this.
//!
//! In lockstep one frame goes down and one up in every round. A position that is sent in one round is needed in the
//! next at the earliest, so positions travel with the rounds. A frame that is lost is sent again, and a round that comes
//! twice is answered from memory: a cut of the network that is shorter than `host_timeout_s` changes nothing but the
//! wall time.
//!
//! On the wall clock what is new goes at once, and what is lost is replaced by what is newer. Only records are sent
//! again. The relay knows the [`clock`] of the plant's host, with a bound, and shows its agents the time of the run on
//! it.

pub mod address;
pub mod carrier;
pub mod clock;
pub mod frame;
pub mod hello;
mod log;
pub mod network;
pub mod relay;
pub mod stand_in;
mod timing;
