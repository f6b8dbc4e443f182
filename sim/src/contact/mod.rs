//! Which contacts stick.

pub(crate) mod friction_solver;
