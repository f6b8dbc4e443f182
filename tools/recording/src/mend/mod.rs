//! Data that are not what they seem: counters that wrap, restart or glitch, rows that arrive in bursts, poses that
//! jump. What is certain can be undone; nothing here changes a recording by itself.
//!
//! Everything reads a stream row by row, a few times, in memory that grows with the number of faults alone.
//! Thresholds are multiples of what the column itself does in an interval (`scale`).

mod bursts;
mod column;
mod glitches;
mod jumps;
mod pose_jumps;
mod scale;
mod undo;
mod wheels;
mod words;
mod wraps;

pub(crate) use bursts::bursts;
pub(crate) use jumps::Jump;
pub use pose_jumps::PoseJump;
pub(crate) use pose_jumps::pose_jumps;
pub(crate) use scale::interval_s;
pub(crate) use undo::MendedWheels;
pub(crate) use wheels::{Fault, Level, WheelFaults, wheels};
pub(crate) use words::times;
