//! The plant against closed forms, laws and references.

mod closed_forms;
mod convergence;
mod derivatives;
mod laws;
mod support;
