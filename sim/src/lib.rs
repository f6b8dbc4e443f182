//! The world of a run: plant, effects and sensors.

mod contact;
mod dynamics;
pub mod effects;
mod integrate;
mod parts;
mod robot;
pub mod run;
mod sensors;
mod world;

pub use integrate::State;
pub use parts::command::{Command, CommandKind};
pub use parts::parameters::{Friction, Streams};
pub use parts::scalar::{Pair, Scalar};
pub use robot::body::Contact;
pub use robot::{GRAVITY_M_S2, Listed, Robot, lift, read_effects};
pub use sensors::Stream;
pub use world::{Sample, Setup, Truth, World};
