//! What changed while a robot drives: since when, what, and how much.

mod alarm;
mod bank;
mod calibration;
mod change;
mod changes;
mod dynamic;
mod event;
mod evidence;
mod filters;
mod formation;
mod hypotheses;
mod kinematic;
mod learnt;
mod linear;
mod links;
mod robot;
mod session;
mod silence;
mod statistic;

pub use alarm::State;
pub use robot::Smallest;
pub use session::{Change, Event, Question, Watch};
