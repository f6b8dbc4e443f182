//! Topic map: which topic of a bag holds which stream of which robot, as a small TOML file.
//!
//! ```toml
//! format = 1
//! stamps = "message"              # or "log": the time of reception instead of the message's stamp
//! [robots.r1]
//! pose_point = "axle"             # the point that the pose is of; or "centre_of_mass"
//! encoder_counts_per_rev = 4096   # in one turn of a wheel, where wheels are counts
//! command = "/cmd_vel"
//! wheels = { topic = "/joint_states", right = "wheel_right_joint", left = "wheel_left_joint",
//!            quantity = "angle" } # or "speed"; for a command also "torque"
//! odometry = "/odom"
//! pose = { topic = "/tf", parent = "world", frame = "base_link" }
//! imu = "/imu"
//! ```
//!
//! `right` and `left` may be lists of joints, whose mean is taken. Of other messages, they are fields with numbers; wheels may
//! have a topic each:
//!
//! ```toml
//! wheels = { topic = "/sensor_state", right = "right_encoder", left = "left_encoder", quantity = "ticks" }
//! wheels = { right = { topic = "/right_ticks", field = "data" }, left = { topic = "/left_ticks", field = "data" },
//!            quantity = "ticks" }
//! ```
//!
//! `reversed = "right"`, `"left"` or `"both"` turns the sign of wheels that count, or are told, backwards.
//!
//! Of transforms, they are the frames of wheels, which turn in the frame of the robot.

use std::fmt::Write as _;
use std::path::Path;

use slipstream_bag::{Result, read_text};
use slipstream_bus::InputError;

use super::source::Source;
use crate::recording::is_robot_name;
use crate::table::StreamKind;
use crate::toml_files::{TomlFile, counts_value, quoted};

/// Which topic of a bag holds which stream of which robot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TopicMap {
    /// Whether to use log times instead of the stamps in the messages.
    pub(super) log_times: bool,
    /// The streams.
    pub(super) sources: Vec<Source>,
    /// What is said of robots beside their streams.
    pub(super) robots: Vec<RobotEntry>,
}

/// What is said of a robot beside its streams.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RobotEntry {
    pub(super) name: String,
    /// Whether its pose is that of the centre of mass. Otherwise it is that of the axle's middle, where `base_link` mostly
    /// lies.
    pub(super) is_pose_of_mass: bool,
    pub(super) encoder_counts_per_rev: Option<f64>,
}

/// Key of the point that a robot's pose is of.
const POSE_POINT: &str = "pose_point";
/// Key of the counts in one turn of a wheel.
const COUNTS: &str = "encoder_counts_per_rev";

impl TopicMap {
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
    /// As [`TopicMap::read`].
    pub fn parse(text: &str, path: &Path) -> std::result::Result<Self, InputError> {
        let file = TomlFile { path, text };
        let table = file.parse()?;
        let root = file.root(&table);
        root.require_format_1()?;
        root.allow_only(&["format", "stamps", "robots"])?;
        let mut map = Self::default();
        if let Some(stamps) = root.get("stamps") {
            map.log_times = match stamps.text()? {
                "message" => false,
                "log" => true,
                _ => return Err(stamps.error("is not valid", "write \"message\" or \"log\"")),
            };
        }
        for (robot, entry) in root.require("robots")?.section()?.entries() {
            if !is_robot_name(robot) {
                return Err(entry.error(
                    "is not a valid robot name",
                    "use letters, digits, `_` and `-`",
                ));
            }
            let section = entry.section()?;
            let mut keys = StreamKind::ALL.map(StreamKind::name).to_vec();
            keys.extend([POSE_POINT, COUNTS]);
            section.allow_only(&keys)?;
            let counts = section.get(COUNTS).map(|counts| counts.counts_per_rev());
            map.robots.push(RobotEntry {
                name: robot.to_owned(),
                is_pose_of_mass: section.is_pose_of_mass()?,
                encoder_counts_per_rev: counts.transpose()?,
            });
            for kind in StreamKind::ALL {
                if let Some(entry) = section.get(kind.name()) {
                    map.sources.push(Source::parse(robot, kind, &entry)?);
                }
            }
        }
        if map.sources.is_empty() {
            let robots = root.require("robots")?;
            return Err(robots.error("maps no topic", "add lines such as `pose = \"/pose\"`"));
        }
        Ok(map)
    }

    /// The topics that it names.
    pub(crate) fn topics(&self) -> Vec<&str> {
        self.sources.iter().flat_map(Source::topics).collect()
    }

    /// The map as TOML; parsing it gives the same map.
    pub fn to_text(&self) -> String {
        let mut text = String::from("format = 1\n");
        let stamps = if self.log_times { "log" } else { "message" };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "stamps = \"{stamps}\"");
        let mut robot = "";
        for source in &self.sources {
            if source.robot != robot {
                robot = &source.robot;
                let _ = writeln!(text, "[robots.{}]", quoted(robot));
                let entry = self.robots.iter().find(|own| own.name == source.robot);
                if entry.is_some_and(|own| own.is_pose_of_mass) {
                    let _ = writeln!(text, "{POSE_POINT} = \"centre_of_mass\"");
                }
                if let Some(counts) = entry.and_then(|own| own.encoder_counts_per_rev) {
                    let _ = writeln!(text, "{COUNTS} = {}", counts_value(counts));
                }
            }
            let _ = writeln!(text, "{} = {}", source.kind.name(), source.to_text());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_round_trips() {
        let text = "format = 1\nstamps = \"log\"\n[robots.r1]\ncommand = \"/cmd_vel\"\n\
            wheels = { topic = \"/joint_states\", right = [\"fr\", \"rr\"], left = \"wl\", quantity = \"speed\" }\n\
            pose = { topic = \"/tf\", parent = \"map\", frame = \"base_link\" }\n\
            [robots.r2]\n\
            encoder_counts_per_rev = 2578.33\n\
            command = { topic = \"/motors\", right = \"volts[1]\", left = \"volts[0]\", quantity = \"voltage\" }\n\
            wheels = { right = { topic = \"/r\", field = \"data\" }, left = { topic = \"/l\", field = \"data\" }, \
            quantity = \"ticks\", reversed = \"left\" }\n";
        let map = TopicMap::parse(text, Path::new("map.toml")).unwrap();
        assert_eq!(map.sources.len(), 5);
        assert_eq!(
            map.to_text()
                .replace("robots.\"", "robots.")
                .replace("\"]\n", "]\n"),
            text
        );
    }

    #[test]
    fn wheels_with_a_topic_each_need_one_for_both_and_a_quantity() {
        let error = |value: &str| {
            let text = format!("format = 1\n[robots.r1]\nwheels = {value}\n");
            let error = TopicMap::parse(&text, Path::new("map.toml")).unwrap_err();
            error.to_string()
        };
        let right = "right = { topic = \"/r\", field = \"data\" }";
        let one = error(&format!(
            "{{ {right}, left = \"data\", quantity = \"ticks\" }}"
        ));
        assert!(one.contains("robots.r1.wheels.left"), "{one}");
        let left = "left = { topic = \"/l\", field = \"data\" }";
        let none = error(&format!("{{ {right}, {left} }}"));
        assert!(
            none.contains("map.toml:3: robots.r1.wheels.quantity"),
            "{none}"
        );
        let mean =
            error("{ topic = \"/b\", right = [\"a\", \"b\"], left = \"c\", quantity = \"ticks\" }");
        assert!(mean.contains("a mean of counters"), "{mean}");
    }

    #[test]
    fn an_unknown_key_is_an_error_with_its_line() {
        let text = "format = 1\n[robots.r1]\ncamera = \"/cam\"\n";
        let error = TopicMap::parse(text, Path::new("map.toml")).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("map.toml:3: robots.r1.camera is not a key")
        );
    }
}
