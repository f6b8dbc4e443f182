//! Wall clock of a run: absolute deadlines on the system's monotonic clock, deadline counting, and
//! real-time scheduling.

mod deadlines;
mod real_time;
mod wall_clock;

pub use deadlines::Deadlines;
pub use real_time::RealTime;
pub use wall_clock::{Monotonic, WallClock};
