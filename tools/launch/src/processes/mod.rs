//! A run as processes: the launcher, and the roles that it starts.

mod child;
mod launcher;
mod options;
mod preflight;
mod progress_line;
mod report;
pub mod roles;
mod signals;

pub use launcher::run;
pub use options::{LaunchError, Options};
