//! From a request to an experiment that can run: keys with provenance, robot models, measured delays.

mod experiment;
mod key_tree;
mod keys;
mod lab;
mod recorded;
mod request;
mod robots;
mod round_trips;

pub use experiment::resolve;
pub use key_tree::BUILT_IN;
pub use request::{Assumption, Origin, Request, Resolved};
