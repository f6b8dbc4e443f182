//! What communication delay does: a grid of delay, jitter, loss, gain, torque limit and protocol,
//! several runs at each point, and the paper's Eq. 13 and 14 beside what is measured.

mod answers;
mod forms;
mod grid;
mod merge;
mod point;
mod report;
mod runs;
mod watch;

pub use answers::{Answer, answers};
pub use forms::{Form, string_gain, string_gain_at};
pub use grid::{Cell, Grid, Shard};
pub use merge::{merge, read};
pub use point::{Fit, Point};
pub use report::page;
pub use runs::{points, study};
pub use watch::{Tick, Watch};

use serde::{Deserialize, Serialize};

/// A study of the delay, or one shard of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// The format's number.
    pub format: u32,
    /// What was asked for.
    pub grid: Grid,
    /// Which part of it this is.
    pub shard: Shard,
    /// The points, in the grid's order.
    pub points: Vec<Point>,
    /// What they say; only of a whole study.
    pub answers: Vec<Answer>,
    /// Whether it was interrupted: the points are those that were finished.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub interrupted: bool,
}
