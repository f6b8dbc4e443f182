//! Output files: written beside their name and moved there once they are whole.
//!
//! An interruption, a full disk or a second program never leaves part of a file under its final
//! name. The recording of a run is the exception: it grows under its name, so that it can be read
//! if the run dies, and is locked while it grows ([`lock_recording`]).

mod beside;
mod file;
mod folder;
mod lock;

pub(crate) use beside::temporary_file;
pub use beside::{remove_unfinished, unnamed_file};
pub use file::{OutputFile, write_file};
pub use folder::OutputFolder;
pub use lock::lock_recording;
