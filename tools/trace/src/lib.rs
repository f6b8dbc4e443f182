//! End-to-end latency, stage by stage: each position message of a run is followed from the encoder
//! sample behind it to the torque that results from it.
//!
//! All times are integer nanoseconds of the run's clock. In a run across hosts every host has its own
//! estimate of it: a stage that ends on another host than it begins has an [`Uncertainty`]. No message is left out: one without a
//! complete cause-effect chain is counted under the reason why its chain is incomplete.

mod answer;
mod both;
mod chain;
mod compare;
mod hosts;
mod log;
mod names;
mod percentiles;
mod perfetto;
mod pile;
mod read;
mod round_trips;
mod step;
mod uncertain_groups;
mod uncertainty;

pub use answer::{
    Age, AgeLine, Hop, Host, Incomplete, LatencyAnswer, LoopTiming, StageLatency, TopicDelay,
    ages_over_time, answer,
};
pub use both::both;
pub use chain::{Chain, Fate, STAGES, TracedMessage, follow};
pub use compare::{HopChange, LatencyChange, against};
pub use log::{Log, Note};
pub use percentiles::Percentiles;
pub use perfetto::timeline;
pub use read::{TraceReading, read};
pub use round_trips::{RoundTrips, round_trips};
pub use step::{Clock, Loop, Step, Topic};
pub use uncertainty::Uncertainty;
