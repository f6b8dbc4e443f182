//! A run as processes: the launcher, and the roles that it starts.

mod away;
mod belongings;
mod child;
mod guests;
mod hang;
mod joining;
mod launcher;
mod options;
mod outcome;
mod part;
mod preflight;
mod progress_line;
pub mod roles;
mod signals;
mod silence;

pub use joining::{Joined, Joining, join};
pub use launcher::run;
pub use options::{Across, LaunchError, Options, Serve};
