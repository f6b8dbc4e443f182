//! Plans: which cases a trial consists of.

mod battery;
mod case_spec;
mod draw_scene;
mod list;
mod sealed;

pub use list::{Plan, PlannedCase};
