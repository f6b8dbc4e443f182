//! A run as processes: the launcher, and the roles that it starts.

mod child;
mod hang;
mod launcher;
mod options;
mod outcome;
mod preflight;
mod progress_line;
mod report;
pub mod roles;
mod signals;
mod silence;

pub use launcher::run;
pub use options::{LaunchError, Options, Serve};
