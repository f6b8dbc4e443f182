//! What a recording says beyond a fit: which terms it needs, and what each is worth.

pub(crate) mod calibration;
pub(crate) mod drive;
mod open_loop;
mod terms;
