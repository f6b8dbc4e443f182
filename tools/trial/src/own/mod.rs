//! A trial on somebody's own recording: known changes are put into copies of it, and none into others; each
//! copy is diagnosed against the original.
//!
//! A change is put into the data themselves, so that its size is exact whatever the machine: stamps are
//! moved, counts are scaled, the tracked point is moved in the frame of the robot, commands are scaled.

mod change;
mod made;
mod menu;
mod null;
mod rows;
mod score;
mod since;

pub use change::Change;
pub use made::alone;
pub use made::{OwnCase, OwnTrial, make};
pub use null::half;
pub use rows::span_s;
pub use score::{Detectable, OwnReport, score};
pub use since::changed_since;
