//! Plans: which cases a trial consists of.

mod battery;
mod case_spec;
mod draw_scene;
mod kinematic;
mod list;
mod noise;
mod sealed;
mod starts;

pub use list::{Plan, PlannedCase};
