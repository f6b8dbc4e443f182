//! Selection of the physics that a recording needs: one criterion; forward by what is lacking most, each look-alike
//! in the place of the other, then backward elimination.
//!
//! Nothing here knows a robot: a term is a set of parameters that are 0 without it.

pub(crate) mod chosen;
pub(crate) mod criterion;
pub(crate) mod effort;
pub(crate) mod elimination;
mod exchange;
mod forward;
pub(crate) mod halves;
mod screen;
pub(crate) mod selected;
