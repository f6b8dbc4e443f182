//! Transport on one host: zero-copy shared memory (iceoryx2), a page on which processes wake each
//! other, clocks, and the recorded trace.

pub mod clock;
pub mod endpoints;
pub mod join;
pub mod record_pipe;
pub mod run_directory;
pub mod services;
pub mod trace;
pub mod wake_page;
mod wire;

pub use wire::{WireEncoders, WirePosition, WireTorque, WorldHeader};
