//! What all processes of a run share. The lowest room of the house: it imports from no other.

pub mod model;
pub mod sensors;

pub use model::{Body, EffectSpec, Encoder, ModelError, Motor, Parameter, RobotModel};
pub use sensors::{Camera, Imu, Sensors};
