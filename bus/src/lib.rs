//! What all processes of a run share. The lowest room of the house: it imports from no other.

pub mod bell;
mod check;
pub mod clock;
pub mod experiment;
pub mod link;
pub mod message;
pub mod model;
pub mod place;
pub mod record;
pub mod record_pipe;
pub mod role;
pub mod sensors;
pub mod services;
pub mod shared;
pub mod time;
pub mod trace;
pub mod transport;

pub use check::SettingError;
pub use experiment::{Experiment, RobotSetup, Settings};
pub use model::{Body, EffectSpec, Encoder, ModelError, Motor, Parameter, RobotModel};
pub use sensors::{Camera, Imu, Sensors};
