//! Runs and recordings as they happen, for Foxglove and other viewers that speak its WebSocket protocol.
//!
//! [`Server`] hands messages to whoever is connected. The recorder of a run gives it every message that it writes; [`play`] gives it
//! those of a recording at the speed at which they were recorded. [`layout`] is a Foxglove layout that shows what matters.
//!
//! The other way round, a [`source`](mod@source) has the rows of a robot as it drives.

mod layout;
mod play;
mod server;
pub mod source;

pub use layout::layout;
pub use play::{Playback, converted, play};
pub use server::Server;
