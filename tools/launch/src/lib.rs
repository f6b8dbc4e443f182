//! One run: the experiment resolved, its processes started, watched and stopped, or all of it in
//! one process.

pub mod in_process;

pub use in_process::{Reports, RunError};
