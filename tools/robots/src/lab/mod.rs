//! `robots.toml`: which robots there are, their topics and limits, and how they are reached.

mod content;
mod file;
mod keys;
mod robot;

pub(crate) use self::content::CONTENTS;
pub use self::content::Content;
pub use self::robot::{CommandMessage, CommandTopic, Lab, LabRobot, PoseTopic, WheelTopic, Wire};
