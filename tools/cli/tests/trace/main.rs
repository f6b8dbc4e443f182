//! `slipstream trace` on the command line: what a run injects is found again in its recording.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod accounting;
#[path = "../common/mod.rs"]
mod common;
mod delays;
mod helpers;
mod hosts;
mod invalid_input;
mod stages;
mod timeline;
mod tracing;
