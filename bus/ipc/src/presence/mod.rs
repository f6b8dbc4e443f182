//! Presence of a process in a run: it shows that it lives, and ends with its launcher.

mod life;
mod parent;

pub(crate) use life::POLL_INTERVAL;
pub use life::Presence;
pub use parent::Parent;
