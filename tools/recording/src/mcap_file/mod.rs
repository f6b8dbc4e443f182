//! Recordings as MCAP files in slipstream's own layout: reader, writer, and the trace of a run.

mod flow;
mod messages;
mod reader;
mod standard;
mod stream_writer;
mod trace;
mod writer;

pub(crate) use flow::OwnFlow;
pub use messages::read_messages;
pub use reader::read_mcap_from;
pub(crate) use reader::{is_own, is_stream, read_own};
pub use trace::{TraceFile, read_trace};
pub use writer::{mcap_bytes, write_mcap};
