//! Recordings: one in-memory form, in and out as MCAP and as CSV folders; the robot's model.

mod bag;
mod build;
mod check;
mod compare;
mod csv_file;
mod csv_in;
mod csv_out;
mod error;
mod foreign;
mod mcap_in;
mod mcap_out;
mod open;
pub mod recording;
mod recording_toml;
pub mod robot_toml;
mod ros2;
pub mod run_writer;
mod sample;
mod standard;
mod table;
mod time;
mod toml_file;
mod topic_map;
mod topics;

pub use bag::reader::Loss;
pub use check::{Finding, Report, RobotReport, Severity, StreamReport, check};
pub use compare::{Channel, CompareError, compare};
pub use csv_in::{Import, read_folder};
pub use csv_out::write_folder;
pub use error::{Error, Result, Unusable};
pub use mcap_in::read_mcap_from;
pub use mcap_out::{write_mcap, write_mcap_to};
pub use open::{read, read_mapped};
pub use recording::Recording;
pub use table::StreamKind;
pub use topic_map::TopicMap;
