//! What all processes of a run share. The lowest room of the house: it imports from no other.

mod check;
pub mod experiment;
pub mod link;
pub mod message;
pub mod model;
pub mod record;
pub mod time;
pub mod transport;

pub use check::SettingError;
pub use experiment::{Experiment, RobotSetup, Settings};
pub use model::{Body, EffectSpec, Encoder, ModelError, Motor, Parameter, RobotModel};
