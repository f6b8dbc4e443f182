//! What a recording says beyond a fit: which terms it needs, and what each is worth.

pub(crate) mod against;
mod bench;
pub(crate) mod claim;
pub(crate) mod collected;
mod drawn_span;
pub(crate) mod dynamic;
mod errors;
mod figures;
pub(crate) mod finding;
mod fitted;
mod fitted_noise;
pub(crate) mod kinematic;
mod limits;
pub(crate) mod links;
pub(crate) mod naming;
mod open_loop;
mod pictures;
mod poses;
mod prediction;
mod scene;
mod search;
mod sight;
mod spread;
mod thinning;
mod today;
mod wheels;
