//! Runs and recordings as they happen, for Foxglove and other viewers that speak its WebSocket protocol.
//!
//! [`Server`] hands messages to whoever is connected. The recorder of a run gives it every message that it writes; [`play`] gives it
//! those of a recording at the speed at which they were recorded. [`layout`] is a Foxglove layout that shows what matters.

mod layout;
mod play;
mod server;

pub use layout::layout;
pub use play::{Playback, converted, play};
pub use server::Server;
