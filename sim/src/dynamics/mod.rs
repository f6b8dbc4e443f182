//! Forces, and constrained accelerations for one set of sticking elements.

pub(crate) mod constrained;
pub(crate) mod forces;
pub(crate) mod inertia;
pub(crate) mod prescribed;
