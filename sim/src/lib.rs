//! The world: plant, effects and sensors.

mod attempt;
mod balance;
mod command;
mod cruise;
mod drive;
pub mod effects;
mod events;
mod grouping;
mod noise;
mod operator;
mod parts;
mod robot;
mod rows;
pub mod run;
mod scalar;
mod sensing;
mod short;
mod skid;
mod state;
mod step;
mod travel;
mod world;

pub use command::{Command, CommandKind};
pub use parts::{Grip, Streams};
pub use robot::{GRAVITY_M_S2, Listed, Robot, lift, read_effects};
pub use scalar::{Pair, Scalar};
pub use sensing::Stream;
pub use state::{Contact, State};
pub use world::{Sample, Setup, Truth, World};
