//! Directory of a run in shared memory, with a lock that tells whether the run is alive.
//!
//! All files of a run begin with `/dev/shm/slipstream-<identity>`: a folder with the experiment,
//! the wake-up page and iceoryx2's own files, and beside it iceoryx2's shared memory. Every process
//! of the run holds a shared lock in the folder. The operating system releases it however the
//! process ends.

mod directory;
mod leftovers;

pub use directory::{RunDirectory, RunLock, SHARED_MEMORY};
pub use leftovers::{Leftover, leftovers};
