//! Plain data and pure logic of a run: robot model, experiment, messages, records, links with their
//! delay line, and the traits of a transport.
//!
//! Nothing here touches the operating system. Shared memory, clocks and processes are in
//! `slipstream-ipc`; file formats are in `slipstream-bag`, `slipstream-recording` and `slipstream-launch`.
//!
//! ```
//! use slipstream_bus::{Experiment, RobotModel, Settings};
//!
//! let mut settings = Settings::default(); // the paper's platoon of three robots
//! settings.links.delay_s = 0.05;
//! settings.validate()?;
//! let experiment = Experiment::new(settings, &RobotModel::paper_with_slip());
//! assert_eq!(experiment.robots[2].name, "r3");
//! # Ok::<(), slipstream_bus::InputError>(())
//! ```

mod error;
pub mod experiment;
pub mod link;
pub mod message;
pub mod range;
pub mod record;
pub mod robot;
pub mod sensors;
pub mod shard;
pub mod time;
pub mod trace;
pub mod transport;
mod twist_limits;

pub use error::InputError;
pub use experiment::{Experiment, RobotSetup, Settings};
pub use robot::{Body, EffectSpec, Encoder, Motor, Parameter, RobotModel};
pub use sensors::{Camera, Imu, Sensors};
pub use shard::Shard;
pub use twist_limits::TwistLimits;
