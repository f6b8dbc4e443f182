//! Recorder of a run: writes a run to an MCAP file while it happens.
//!
//! ```
//! use slipstream_recording::recording::{Recording, Robot};
//! use slipstream_recording::run_writer::{RunHeader, RunWriter};
//!
//! let header = RunHeader {
//!     description: Recording {
//!         robots: vec![Robot::named("r1")],
//!         ..Recording::default()
//!     },
//!     ..RunHeader::default()
//! };
//! let path = "run.mcap".as_ref(); // for errors only: this run is written to memory
//! let mut bytes = Vec::new();
//! let mut run = RunWriter::to_sink(&mut bytes, path, &header)?;
//! run.write_camera(0, 20_000_000, [1.0, 2.0, 0.5])?; // robot 0 at 0.02 s
//! run.flush()?;
//! run.finish()?;
//!
//! let import = slipstream_recording::read_mcap_from(&bytes[..], bytes.len() as u64, path)?;
//! let pose = import.recording.robots[0].pose.as_ref();
//! assert_eq!(pose.map(|pose| pose.t_s.clone()), Some(vec![0.02]));
//! # Ok::<(), slipstream_recording::Error>(())
//! ```

mod channels;
mod contact;
mod header;
mod writer;

pub use crate::position::{Fate, PositionRecord};
pub use contact::WheelContact;
pub use header::{Attachment, RunHeader};
pub use writer::RunWriter;
