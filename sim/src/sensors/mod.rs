//! Sampling, stamps and noise.

pub(crate) mod measurement;
pub(crate) mod noise;

pub use measurement::Stream;
