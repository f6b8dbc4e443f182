//! One run: the experiment resolved, its processes started, watched and stopped, or all of it in
//! one process.

pub mod in_process;
mod keys;
pub mod launcher;
mod live;
pub mod outcome;
mod place_files;
mod preflight;
pub mod recorder;
pub mod resolve;
pub mod roles;
mod round_trips;
pub mod sink;
mod tape;

pub use in_process::{Reports, RunError};
pub use launcher::{LaunchError, Options};
pub use outcome::{Outcome, Verdict};
pub use resolve::{Assumption, Request, Resolved, resolve};
pub use slipstream_bus::InputError as Unusable;
