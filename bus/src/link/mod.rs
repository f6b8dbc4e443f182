//! Links from robot to robot: random impairment (delay, jitter, loss) and the receiver's delay
//! line.

mod delay_line;
mod impairment;

pub use delay_line::{Arrival, DelayLine, InFlight, LinkCounts};
pub use impairment::LinkImpairment;
