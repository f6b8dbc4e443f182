//! Column map: which column of which text file is which column of which stream, as a small TOML file.
//!
//! ```toml
//! format = 1
//! [robots.r1.wheels]
//! file = "log.csv"                # in the recording's folder; not needed if the recording is one file
//! t_s = { column = "time_ms", factor = 0.001 }
//! angle_right_rad = "right"       # the name of the column
//! angle_left_rad = "left"
//! [robots.r1.pose]
//! file = "camera.txt"
//! separator = ";"                 # recognised, where it is not said; " " stands for runs of blanks
//! header = false                  # likewise; then columns are numbers, from 1 on
//! t_s = 1                         # numbers, or dates with times; t_ns has nanoseconds beside seconds; period_s = 0.1
//! x_m = 2                         # stands for a column of times, times = "times.txt" for a file with one in each line
//! y_m = 3
//! yaw_rad = { column = 4, factor = 0.017453292519943295, offset = -1.5707963267948966 }
//! ```
//!
//! In place of `yaw_rad`, a pose may have a quaternion (`qz`, `qw`, and `qx`, `qy` if the file has them) or a vector that
//! points forwards (`forward_x`, `forward_y`).
//!
//! A cell becomes `cell * factor + offset`. Rows in which all columns of a stream are empty do not belong to it, so that
//! one file may hold several streams. Lines that begin with `#`, `%` or `//` are comments; the last one before the first
//! row has the names of the columns if it has as many words.

use std::path::Path;

use slipstream_bag::{Result, read_text};
use slipstream_bus::InputError;

use super::entry::{RobotEntry, StreamEntry};
use super::stream_table::parse_stream;
use crate::recording::{PosePoint, Robot, is_robot_name};
use crate::table::StreamKind;
use crate::toml_files::{Section, TomlFile};

/// Which column of which file is which column of which stream.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ColumnMap {
    /// The robots, without streams.
    pub(super) robots: Vec<RobotEntry>,
    /// The streams.
    pub(super) streams: Vec<StreamEntry>,
}

/// Keys of a robot besides its streams.
const ROBOT_KEYS: [&str; 2] = ["pose_point", "encoder_counts_per_rev"];

type ParsedMap<T> = std::result::Result<T, InputError>;

impl ColumnMap {
    /// Reads a map from a file.
    ///
    /// # Errors
    /// If the file cannot be read or violates the format, with file and line.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::parse(&read_text(path)?, path)?)
    }

    /// Parses the text of a map. `path` is used in errors only.
    ///
    /// # Errors
    /// As [`ColumnMap::read`].
    pub fn parse(text: &str, path: &Path) -> ParsedMap<Self> {
        let file = TomlFile { path, text };
        let table = file.parse()?;
        let root = file.root(&table);
        root.require_format_1()?;
        root.allow_only(&["format", "robots"])?;
        let robots = root.require("robots")?;
        let mut map = Self::default();
        for (name, entry) in robots.section()?.entries() {
            if !is_robot_name(name) {
                let remedy = "use letters, digits, `_` and `-`";
                return Err(entry.error("is not a valid robot name", remedy));
            }
            map.add_robot(name, &entry.section()?)?;
        }
        if map.streams.is_empty() {
            let remedy = "add a table such as [robots.r1.pose]";
            return Err(robots.error("maps no stream", remedy));
        }
        Ok(map)
    }

    fn add_robot(&mut self, name: &str, section: &Section<'_>) -> ParsedMap<()> {
        let mut keys = StreamKind::ALL.map(StreamKind::name).to_vec();
        keys.extend(ROBOT_KEYS);
        section.allow_only(&keys)?;
        self.robots.push(RobotEntry {
            name: name.to_owned(),
            is_pose_of_mass: section.is_pose_of_mass()?,
            encoder_counts_per_rev: section
                .get("encoder_counts_per_rev")
                .map(|counts| counts.counts_per_rev())
                .transpose()?,
        });
        for kind in StreamKind::ALL {
            if let Some(stream) = section.get(kind.name()) {
                self.streams.push(parse_stream(name, kind, &stream)?);
            }
        }
        Ok(())
    }

    /// Whether it maps no stream.
    pub(crate) fn is_empty(&self) -> bool {
        self.streams.is_empty()
    }

    /// The robots, without streams.
    pub(super) fn robots(&self) -> Vec<Robot> {
        let robot = |entry: &RobotEntry| Robot {
            encoder_counts_per_rev: entry.encoder_counts_per_rev,
            pose_point: Some(if entry.is_pose_of_mass {
                PosePoint::CentreOfMass
            } else {
                PosePoint::Axle
            }),
            ..Robot::named(&entry.name)
        };
        self.robots.iter().map(robot).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        let text = format!("format = 1\n[robots.r1.pose]\n{text}");
        let map = ColumnMap::parse(&text, Path::new("map.toml"));
        map.unwrap_err().to_string()
    }

    #[test]
    fn errors_name_line_key_and_remedy() {
        let cases = [
            ("x_m = 1\ny_m = 2", "robots.r1.pose.t_s is missing"),
            ("t_s = \"t\"\nx_m = \"x\"", "y_m"),
            (
                "t_s = 1\nx_m = 1\ny_m = 2\nqz = 3",
                "map.toml:2: robots.r1.pose.qw is missing",
            ),
            (
                "t_s = 1\nx_m = 1\ny_m = 2\nqz = 3\nqw = 4\nyaw_rad = 5",
                "map.toml:8: robots.r1.pose.yaw_rad is one of two sources of the yaw",
            ),
            (
                "t_s = 1\nperiod_s = 0.1\nx_m = 1\ny_m = 2",
                "map.toml:3: robots.r1.pose.t_s stands beside period_s",
            ),
            (
                "period_s = 0\nx_m = 1\ny_m = 2",
                "map.toml:3: robots.r1.pose.period_s is not above 0",
            ),
            (
                "t_s = 1\nt_ns = { column = 2, factor = 2 }\nx_m = 1\ny_m = 2",
                "map.toml:4: robots.r1.pose.t_ns is converted",
            ),
            (
                "t_s = \"t\"\nx = 1",
                "map.toml:4: robots.r1.pose.x is not a key",
            ),
            (
                "header = false\nt_s = \"t\"\nx_m = 1\ny_m = 2",
                "but the file has no header",
            ),
            ("t_s = 0\nx_m = 1\ny_m = 2", "is not a column"),
            (
                "t_s = { column = 1, factor = 0 }\nx_m = 1\ny_m = 2",
                "has the factor 0",
            ),
            (
                "file = \"../x.csv\"\nt_s = 1\nx_m = 1\ny_m = 2",
                "leads out of the folder",
            ),
            (
                "separator = \";;\"\nt_s = 1\nx_m = 1\ny_m = 2",
                "is not one character",
            ),
        ];
        for (text, expected) in cases {
            let error = error(text);
            assert!(error.contains(expected), "{error}");
        }
    }
}
