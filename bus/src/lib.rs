//! Plain data and pure logic that every part of a run shares: robot model, experiment, messages,
//! records, links with their delay line, and the traits of a transport. No operating system: shared
//! memory, clocks and processes are in `slipstream-ipc`.

mod error;
pub mod experiment;
pub mod link;
pub mod message;
pub mod record;
pub mod robot;
pub mod sensors;
pub mod time;
pub mod topology;
pub mod trace;
pub mod transport;
mod validate;

pub use error::InputError;
pub use experiment::{Experiment, RobotSetup, Settings};
pub use robot::{Body, EffectSpec, Encoder, Motor, Parameter, RobotModel};
pub use sensors::{Camera, Imu, Sensors};
