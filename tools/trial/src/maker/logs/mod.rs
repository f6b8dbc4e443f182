//! Cases of the plan `logs`: robots told speeds, or whose wheels and reference alone were recorded, with what logs of
//! real robots have. [`nuisances`] is the table of all that, `effects` the table of what is concealed beside it.

mod counters;
mod course;
mod effects;
mod label;
mod log;
mod make;
mod nuisances;
mod plant;
mod references;
mod robot;
mod rows;
mod sampled;
mod stamps;
#[cfg(test)]
mod tests;
mod wander;

pub(super) use log::Log;
pub(super) use make::{draw, make};
