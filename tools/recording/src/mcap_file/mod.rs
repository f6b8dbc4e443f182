//! A recording as an MCAP file of slipstream.

mod reader;
mod standard;
mod trace;
mod writer;

pub use reader::read_mcap_from;
pub(crate) use reader::read_own;
pub use trace::{TraceFile, read_trace};
pub use writer::{write_mcap, write_mcap_to};
