//! Runs of real robots as a user starts them. The robots are boxes: our plant behind the topics of a real robot, each a
//! process of its own.
//!
//! Needs the feature `hosts` (`just real`). `SLIPSTREAM_FAULTS=1000` is the long form of the test of faults (`just faults`).
#![cfg(feature = "hosts")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;

mod closed_loop;
mod faults;
mod lab;
mod looking;
mod peer;
mod proxy;
mod torques;
