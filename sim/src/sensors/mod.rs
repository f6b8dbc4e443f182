//! Sensors: measurement functions, time stamps, sampling and noise.

pub(crate) mod measurement;
pub(crate) mod noise;
pub(crate) mod sampler;

pub use measurement::Stream;
pub use sampler::Sample;
