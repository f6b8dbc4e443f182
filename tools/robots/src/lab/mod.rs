//! `robots.toml`: which robots there are, their topics and limits, and how they are reached.

mod file;
mod keys;
mod robot;

pub use self::robot::{CommandTopic, Lab, LabRobot, PoseTopic, WheelTopic, Wire};
