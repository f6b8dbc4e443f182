//! Messages of a robot as it drives: rows of a recording that has no end yet.

mod channels;
mod follower;
mod kept;
mod parts;

pub use follower::{Followed, Follower};
pub use parts::next_part;
