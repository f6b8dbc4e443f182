//! A run as processes: the launcher, and the roles that it starts.

mod child;
mod hang;
mod joined_host;
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
mod ssh_hosts;
mod state_transfer;

pub use joining::{Joined, Joining, join};
pub use launcher::run;
pub use options::{Across, LaunchError, Options, Serve};
