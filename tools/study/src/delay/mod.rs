//! What communication delay does to a platoon: a grid over delay, jitter, loss, gain, torque limit and
//! protocol, several runs at each point, and the paper's Eq. 13 and 14 beside what is measured.

mod answers;
mod effect;
mod follower_recorder;
mod forms;
mod grid;
mod merge;
mod point;
mod run_points;
mod sentence;
mod string_stability;
mod study;

pub use answers::{StudyAnswer, Table, answers};
pub use effect::effect;
pub use follower_recorder::{FollowerRecorder, FollowerTick};
pub use forms::Form;
pub use grid::{Grid, GridCell};
pub use merge::merge;
pub use point::{FormError, Point, RunResult};
pub use run_points::run_points;
pub use string_stability::{string_gain, string_gain_at};
pub use study::{Study, study};
