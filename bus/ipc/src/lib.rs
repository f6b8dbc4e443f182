//! Transport on one host: zero-copy shared memory (iceoryx2), a futex barrier on a shared page,
//! clocks, and the recorder of the trace.
//!
//! A process enters its run with [`join::JoinedRun`], opens its ports with [`endpoints`], and sends
//! its log with [`record_pipe`]. Data goes through the publish-subscribe services of [`services`];
//! the processes wake each other through the [`wake_page`].

pub mod clock;
pub mod endpoints;
pub mod join;
pub mod part;
pub mod presence;
pub mod record_pipe;
pub mod report;
pub mod run_directory;
pub mod services;
pub mod trace;
pub mod wake_page;
mod wire;

pub use wire::WirePosition;
