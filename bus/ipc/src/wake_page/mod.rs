//! Wake-up page: a shared memory page through which the processes of a run synchronise (futex).
//!
//! It carries no messages, only who waits for what: the stage of the run, the barrier of the
//! lockstep, the progress, the signs of life and death counters, and a checkpoint of each agent.
//! Every wait has a timeout, so that the waiting process can check whether the others are alive.
//!
//! With the feature `loom`, atomics, futex and mapping are replaced by models, with which the tests
//! in `model.rs` try every order of the steps of a few threads. Nothing else works then.

mod barrier;
mod checkpoint;
#[cfg(not(feature = "loom"))]
mod futex;
#[cfg(feature = "loom")]
mod futex_model;
#[cfg(feature = "loom")]
mod heap;
mod layout;
#[cfg(not(feature = "loom"))]
mod mapping;
#[cfg(all(test, feature = "loom"))]
mod model;
mod page;
mod signs;
mod stage;
mod sync;

pub use layout::{CHECKPOINT_WORDS, DEADLINE_WORDS};
pub use page::WakePage;
pub use signs::Member;
pub use stage::Stage;
