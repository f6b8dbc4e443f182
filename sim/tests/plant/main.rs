//! The plant against closed forms, laws and references.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

mod closed_forms;
mod convergence;
mod derivatives;
mod effects;
mod laws;
mod paper;
mod support;
