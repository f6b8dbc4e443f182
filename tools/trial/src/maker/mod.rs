//! Makes cases: scenes are drawn from a seed, simulated by a second simulator (by `sim` for effects that
//! only the catalogue has), recorded and labelled.

mod case;
mod catalogue_case;
mod controller;
mod detectability;
mod draw_effect;
mod information;
mod logs;
mod manoeuvre;
mod plan;
mod platoon_link;
mod prediction;
mod process_noise;
mod random;
mod record;
mod reference;
mod robot;
mod scene;
mod sensors;
mod simulate;
mod truth;

pub use case::{MadeCase, make};
pub use draw_effect::VOCABULARY;
pub use manoeuvre::{CommandKind, Style};
pub use plan::{Plan, PlannedCase};
pub use process_noise::{NoiseKind, ProcessNoise};
pub use scene::{Camera, Control, Recorded, Scene, Start, TrueRobot};
