//! What a recording says beyond a fit: which terms it needs, and what each is worth.

pub(crate) mod against;
mod bench;
pub(crate) mod calibration;
pub(crate) mod claim;
pub(crate) mod collected;
pub(crate) mod drawn_span;
pub(crate) mod drive;
mod drive_terms;
pub(crate) mod dynamic;
pub(crate) mod finding;
mod fitted_noise;
pub(crate) mod kinematic;
mod limits;
pub(crate) mod links;
mod open_loop;
pub(crate) mod pictures;
pub(crate) mod prediction;
pub(crate) mod reading;
pub(crate) mod scene;
mod sight;
mod spread;
mod term;
mod terms;
mod thinning;
mod thresholds;
mod today;
mod wheel_side;
