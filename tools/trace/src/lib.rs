//! Latency, stage by stage: from a run's recording each position's way from the encoder sample to
//! the torque that answers it.
//!
//! All times are integer nanoseconds of the run's one clock. Nothing is dropped: a message whose
//! way is not complete is counted by what became of it.

mod against;
mod answer;
mod figures;
mod log;
mod read;
mod round_trips;
mod step;
mod timeline;
mod way;

pub use against::{Change, HopChange, against};
pub use answer::{Age, Answer, Hop, Incomplete, LoopFigures, StageFigures, answer};
pub use figures::Figures;
pub use log::{Log, Note};
pub use read::{Reading, read};
pub use round_trips::{RoundTrips, round_trips};
pub use step::{Loop, Step};
pub use timeline::timeline;
pub use way::{Fate, Message, STAGES, Way, follow};
