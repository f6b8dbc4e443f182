//! Contact problem: which contacts at rest stick and which begin to slide.

mod friction_disc;
pub(crate) mod friction_solver;
