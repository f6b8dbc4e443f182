//! The constants of one robot, its contact Jacobian, and its bodily state.

pub(crate) mod body;
mod constants;
mod jacobian;
mod listed;

pub use constants::{GRAVITY_M_S2, Robot};
pub use listed::{Listed, lift, read_effects};
