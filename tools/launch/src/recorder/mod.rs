//! The recording of a run: from records to an MCAP file.

mod mcap_sink;
mod merge;
pub(crate) mod process;
mod served;
pub(crate) mod trace_files;

pub use mcap_sink::McapSink;
pub(crate) use mcap_sink::begin;
pub use process::RecorderOutcome;
