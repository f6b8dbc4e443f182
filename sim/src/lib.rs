//! The world: plant, effects and sensors.

pub mod run;
mod standin;
pub use standin::{Command, Setup, Truth, World};
