//! Sealed trials of the diagnosis: cases are simulated, concealed, diagnosed, revealed and scored.
//!
//! [`maker`] draws cases and simulates them, by a simulator that is independent of the diagnosis wherever it
//! knows the effect;
//! [`sealed_trial`] writes recordings and commitments before anything is diagnosed; [`protocol`]
//! diagnoses every case in a process of its own and scores the answers against the labels; [`grade`]
//! grades one answer, [`tally`] sums up, [`merge`] sums up the parts of a trial. [`own`] puts known changes into copies of a recording that exists.

pub mod answer;
pub mod diagnosis_process;
mod error;
pub mod grade;
mod in_order;
mod intervals;
pub mod label;
pub mod maker;
pub mod merge;
pub mod own;
pub mod part;
pub mod protocol;
pub mod seal;
pub mod sealed_trial;
pub mod tally;

pub use error::TrialError;
