//! Recordings: one in-memory form, in and out as MCAP and as CSV folders; the robot's model.

mod bag;
mod check;
mod compare;
mod csv_folder;
mod decode;
mod error;
mod foreign_bag;
mod import;
mod mcap_file;
mod open;
pub mod recording;
mod ros2;
pub mod run_writer;
mod table;
mod toml_files;
mod topics;

pub use bag::Loss;
pub use check::{Finding, Report, RobotReport, Severity, StreamReport, check, faults};
pub use compare::{Channel, CompareError, compare};
pub use csv_folder::{read_folder, write_folder};
pub use error::{Error, Result, Unusable};
pub use foreign_bag::TopicMap;
pub use import::Import;
pub use mcap_file::{TraceFile, read_mcap_from, read_trace, write_mcap, write_mcap_to};
pub use open::{read, read_mapped};
pub use recording::Recording;
pub use table::StreamKind;
pub use toml_files::robot_toml;
