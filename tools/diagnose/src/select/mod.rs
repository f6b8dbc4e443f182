//! Selection of the physics that a recording needs: one criterion, backward elimination.
//!
//! Nothing here knows a robot: a term is a set of parameters with neutral values.

pub(crate) mod criterion;
pub(crate) mod elimination;
pub(crate) mod halves;
