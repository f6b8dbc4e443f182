//! Wake-up page: a shared memory page through which the processes of a run synchronise (futex).
//!
//! It carries no messages, only who waits for what: the stage of the run, the barrier of the
//! lockstep, the progress, the signs of life and death counters, and a checkpoint of each agent. Every wait has a
//! timeout, so that the waiting process can check whether the others are alive.

mod barrier;
mod checkpoint;
mod futex;
mod layout;
mod page;
mod signs;
mod stage;

pub use layout::{CHECKPOINT_WORDS, DEADLINE_WORDS};
pub use page::WakePage;
pub use signs::Member;
pub use stage::Stage;
