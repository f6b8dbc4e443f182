//! One run of an experiment: resolve its keys, then run it as processes over shared memory
//! ([`processes::run`]) or in one process on one thread ([`in_process`]). Both give the same states,
//! bit for bit, on the virtual clock.

mod describe;
pub mod in_process;
pub mod processes;
mod program;
pub mod recorder;
pub mod resolve;
mod role;
mod run_files;
pub mod summary;

pub use describe::describe;
pub use in_process::{Reports, RunError};
pub use processes::{Across, LaunchError, Options, Serve};
pub use program::{Program, Programs};
pub use resolve::{Assumption, Request, Resolved, resolve};
pub use summary::{RunStatus, RunSummary};
