//! Makes cases: scenes drawn from a seed, played by a second simulator, recorded and labelled.

mod case;
mod chance;
mod control;
mod drive;
mod effects;
mod manoeuvre;
mod plan;
mod record;
mod scene;
mod sensors;
mod size;
mod trace;

pub use case::{Made, make};
pub use effects::VOCABULARY;
pub use manoeuvre::{Style, Told};
pub use plan::{Plan, Planned};
pub use scene::{Actual, Control, Eye, Scene};
