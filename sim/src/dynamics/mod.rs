//! Equations of motion: forces at one instant, and accelerations constrained by one active set.

pub(crate) mod applied;
pub(crate) mod constrained;
pub(crate) mod forces;
pub(crate) mod inertia;
pub(crate) mod motors;
mod normal_forces;
pub(crate) mod prescribed;
