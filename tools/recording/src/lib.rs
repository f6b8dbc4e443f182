//! Recordings of differential-drive robots: one in-memory form, read from and written to folders of CSV
//! files and MCAP files (ROS 2 bags).
//!
//! [`read`] reads any form into a [`Recording`]; [`write_folder`] and [`write_mcap`] write it. [`read_spooled`]
//! reads recordings that are too long for the memory.
//! [`check()`](check()) finds errors of a recording, [`compare()`](compare()) puts it next to a simulation, [`two_runs`]
//! next to another recording, [`run_writer`] records a run while it happens, [`robot_toml`] reads and writes robot models, and
//! [`robot_file`] reads them from other descriptions, too.
//!
//! A folder of CSV files, read, examined and written as MCAP:
//!
//! ```
//! use slipstream_recording::recording::Wheels;
//! use slipstream_recording::{Severity, check, read, write_mcap};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! std::fs::create_dir(folder.path().join("r1"))?;
//! std::fs::write(folder.path().join("recording.toml"), "format = 1\n[robots.r1]\n")?;
//! std::fs::write(
//!     folder.path().join("r1/wheels.csv"),
//!     "t_s,angle_right_rad,angle_left_rad\n0.00,1.5,0\n0.02,1.6,\n",
//! )?;
//!
//! let import = read(folder.path())?;
//! assert!(import.warnings.is_empty());
//! let robot = import.recording.robot("r1").ok_or("no robot r1")?;
//! let wheels = robot.wheels.as_ref().ok_or("no wheels")?;
//! assert_eq!(wheels.t_s, [0.0, 0.02]);
//! let Wheels::Angle { right_rad, left_rad } = &wheels.values else {
//!     return Err("not recorded as angles".into());
//! };
//! assert_eq!(right_rad, &[1.5, 1.6]);
//! assert!(left_rad[1].is_nan()); // an empty cell
//!
//! let report = check(&import.recording, None);
//! assert!(report.findings.iter().all(|finding| finding.severity != Severity::Error));
//!
//! let file = folder.path().join("run.mcap");
//! write_mcap(&import.recording, &file)?;
//! let wheels = read(&file)?.recording.robots.remove(0).wheels;
//! assert_eq!(wheels.ok_or("no wheels")?.t_s, [0.0, 0.02]);
//! # Ok(())
//! # }
//! ```
//!
//! # Errors
//!
//! Reading and writing fail with [`Error`]. [`Error::Input`] is about a file of the user and names file,
//! line, problem and remedy ([`InputError`]); [`Error::Write`] and [`Error::WriteMcap`] are about output.
//! Damage of an MCAP file is not an error: everything intact is read, and [`Import::loss`] counts the
//! rest.
//!
//! # Units
//!
//! SI units and radians; the unit is in the name of a field (`t_s`, `wheel_radius_m`). x points forward, y
//! to the left, yaw is counter-clockwise. Pairs are [right, left].

mod attached;
mod carried;
mod check;
mod compare;
mod csv_folder;
mod decode;
mod field;
mod follow;
mod foreign_bag;
mod foreign_csv;
mod import;
mod joined;
mod mcap_file;
mod mend;
mod mended;
mod open;
mod pieces;
mod position;
pub mod recording;
pub mod robot_file;
mod rows;
pub mod run_writer;
mod sides;
mod sysid_json;
mod table;
mod toml_files;
mod topics;

pub use attached::attached;
pub use check::{Finding, Report, RobotReport, Severity, StreamReport, check, faults, pose_jumps};
pub use compare::{Channel, CompareError, compare, interpolate, two_runs};
pub use csv_folder::{read_folder, write_folder};
pub use decode::wrapped;
pub use field::Field;
pub use follow::{Followed, Follower, next_part};
pub use foreign_bag::{TopicMap, WheelJoints};
pub use foreign_csv::ColumnMap;
pub use import::{Import, Spooled};
pub use joined::joined;
pub use mcap_file::{TraceFile, mcap_bytes, read_mcap_from, read_messages, read_trace, write_mcap};
pub use mend::PoseJump;
pub use mended::mended;
pub use open::{
    Map, describe_robot, describe_robots, draft_map, read, read_mapped, read_mapped_from,
    read_spooled,
};
pub use pieces::Pieces;
pub use recording::Recording;
pub use rows::Disk;
pub use slipstream_bag::{Error, Result};
pub use slipstream_bus::InputError;
pub use table::{ColumnSet, LINKS, ROUND_TRIPS, StreamKind, TIME};
pub use toml_files::{recording_toml, robot_toml};
