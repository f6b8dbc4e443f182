//! The plant against closed-form solutions, physical laws, its own derivatives and a fine
//! reference.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod catalogue;
mod changes;
mod closed_forms;
mod convergence;
mod derivatives;
mod effects;
mod laws;
mod paper;
mod sensors;
mod support;
