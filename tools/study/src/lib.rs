//! Studies: questions answered by many simulated runs. [`reproduce`] compares the paper's own
//! experiments with its printed numbers; [`delay`] measures what communication delay does to a
//! platoon (Eq. 13 and 14); [`sweep`] runs any experiment at every combination of values of some of its keys.

pub mod delay;
mod error;
pub mod reproduce;
pub mod sweep;

pub use error::StudyError;
