//! The plant against closed forms, laws and references.

mod closed_forms;
mod convergence;
mod derivatives;
mod effects;
mod laws;
mod paper;
mod support;
