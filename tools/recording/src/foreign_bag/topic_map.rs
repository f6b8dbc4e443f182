//! Topic map: which topic of a bag holds which stream of which robot, as a small TOML file.
//!
//! ```toml
//! format = 1
//! stamps = "message"              # or "log": the time of reception instead of the message's stamp
//! [robots.r1]
//! pose_point = "axle"             # the point that the pose is of; or "centre_of_mass"
//! command = "/cmd_vel"
//! wheels = { topic = "/joint_states", right = "wheel_right_joint", left = "wheel_left_joint",
//!            quantity = "angle" } # or "speed"; for a command also "torque"
//! odometry = "/odom"
//! pose = { topic = "/tf", parent = "world", frame = "base_link" }
//! imu = "/imu"
//! ```
//!
//! `right` and `left` may be lists of joints, whose mean is taken.

use std::fmt::Write as _;
use std::path::Path;

use slipstream_bus::InputError;

use crate::decode::MessageSelector;
use crate::error::Result;
use crate::recording::is_robot_name;
use crate::table::StreamKind;
use crate::toml_files::{Entry, TomlFile, quoted, read_text};

/// Which topic of a bag holds which stream of which robot.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TopicMap {
    /// Whether to use log times instead of the stamps in the messages.
    pub(super) log_times: bool,
    /// The streams.
    pub(super) sources: Vec<Source>,
    /// Robots whose pose is that of the centre of mass. Of the others, it is that of the axle's middle, where
    /// `base_link` mostly lies.
    pub(super) with_pose_of_mass: Vec<String>,
}

/// A stream and the topic that holds it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Source {
    pub(super) robot: String,
    pub(super) kind: StreamKind,
    pub(super) topic: String,
    pub(super) selector: MessageSelector,
    /// For joint states: the list to read. Without it, torque for commands and angle for wheels.
    pub(super) quantity: Option<Quantity>,
}

/// One of the three lists of a joint state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Angle,
    Speed,
    Torque,
}

/// The words for the quantities in a map.
const QUANTITIES: [(&str, Quantity); 3] = [
    ("angle", Quantity::Angle),
    ("speed", Quantity::Speed),
    ("torque", Quantity::Torque),
];

/// Key of the point that a robot's pose is of.
const POSE_POINT: &str = "pose_point";

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
            keys.push(POSE_POINT);
            section.allow_only(&keys)?;
            if section.is_pose_of_mass()? {
                map.with_pose_of_mass.push(robot.to_owned());
            }
            for kind in StreamKind::ALL {
                if let Some(entry) = section.get(kind.name()) {
                    map.sources.push(parse_source(robot, kind, &entry)?);
                }
            }
        }
        if map.sources.is_empty() {
            let robots = root.require("robots")?;
            return Err(robots.error("maps no topic", "add lines such as `pose = \"/pose\"`"));
        }
        Ok(map)
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
                if self.with_pose_of_mass.contains(&source.robot) {
                    let _ = writeln!(text, "{POSE_POINT} = \"centre_of_mass\"");
                }
            }
            let _ = writeln!(text, "{} = {}", source.kind.name(), source.to_text());
        }
        text
    }
}

/// One name, or a list of names.
fn names(names: &[String]) -> String {
    match names {
        [name] => quoted(name),
        _ => {
            let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            format!("[{}]", names.join(", "))
        }
    }
}

/// Parses the value of a stream's key: a topic, or a table with further keys.
fn parse_source(
    robot: &str,
    kind: StreamKind,
    entry: &Entry<'_>,
) -> std::result::Result<Source, InputError> {
    let mut source = Source {
        robot: robot.to_owned(),
        kind,
        topic: String::new(),
        selector: MessageSelector::default(),
        quantity: None,
    };
    if let Ok(topic) = entry.text() {
        source.topic = topic.to_owned();
        return Ok(source);
    }
    let section = entry.section()?;
    section.allow_only(&["topic", "parent", "frame", "right", "left", "quantity"])?;
    source.topic = section.require("topic")?.text()?.to_owned();
    if let Some(frame) = section.get("frame") {
        source.selector.frame = Some(frame.text()?.to_owned());
    }
    if let Some(parent) = section.get("parent") {
        source.selector.parent = Some(parent.text()?.to_owned());
    }
    for (joints, key) in source.selector.joints.iter_mut().zip(["right", "left"]) {
        if let Some(names) = section.get(key) {
            let list = names.elements();
            let list = list.iter().map(|name| Ok(name.text()?.to_owned()));
            *joints = list.collect::<std::result::Result<_, InputError>>()?;
            if joints.is_empty() {
                return Err(names.error("names no joint", "name the joints of this side"));
            }
        }
    }
    if let Some(entry) = section.get("quantity") {
        let word = entry.text()?;
        let known = QUANTITIES.iter().find(|(name, _)| *name == word);
        let Some((_, quantity)) = known else {
            return Err(entry.error("is not a quantity", "write angle, speed or torque"));
        };
        source.quantity = Some(*quantity);
    }
    Ok(source)
}

impl Source {
    /// The value of the stream's key in a map.
    fn to_text(&self) -> String {
        let topic = quoted(&self.topic);
        let mut keys = vec![format!("topic = {topic}")];
        if let Some(parent) = &self.selector.parent {
            keys.push(format!("parent = {}", quoted(parent)));
        }
        if let Some(frame) = &self.selector.frame {
            keys.push(format!("frame = {}", quoted(frame)));
        }
        if let Some(quantity) = self.quantity {
            let [right, left] = self.selector.joints.each_ref().map(|side| names(side));
            keys.push(format!("right = {right}, left = {left}"));
            let word = QUANTITIES.iter().find(|(_, known)| *known == quantity);
            keys.push(format!(
                "quantity = \"{}\"",
                word.map_or("", |(word, _)| word)
            ));
        }
        if keys.len() == 1 {
            return topic;
        }
        format!("{{ {} }}", keys.join(", "))
    }

    /// The columns of the stream that a message of this type provides; `None` if it cannot provide
    /// the stream.
    pub(super) fn columns(&self, schema: &str) -> Option<&'static [&'static str]> {
        const TWIST: &[&str] = &["v_m_s", "w_rad_s"];
        const POSE: &[&str] = &["x_m", "y_m", "yaw_rad"];
        let quantity = self.quantity.unwrap_or(match self.kind {
            StreamKind::Command => Quantity::Torque,
            _ => Quantity::Angle,
        });
        let name = schema.rsplit('/').next().unwrap_or_default();
        match (self.kind, name) {
            (StreamKind::Command, "Twist" | "TwistStamped" | "struct:ChassisSpeeds") => Some(TWIST),
            (
                StreamKind::Odometry,
                "Twist"
                | "TwistStamped"
                | "TwistWithCovarianceStamped"
                | "Odometry"
                | "struct:ChassisSpeeds",
            ) => Some(TWIST),
            (
                StreamKind::Pose,
                "Pose"
                | "PoseStamped"
                | "PoseWithCovarianceStamped"
                | "TransformStamped"
                | "Odometry"
                | "TFMessage"
                | "tfMessage"
                | "struct:Pose2d",
            ) => Some(POSE),
            (StreamKind::Pose, "PointStamped") => Some(&["x_m", "y_m"]),
            (StreamKind::Imu, "Imu") => Some(&["ax_m_s2", "ay_m_s2", "gz_rad_s"]),
            (StreamKind::Motor, "MotorState") => {
                Some(&["current_right_a", "current_left_a", "supply_v"])
            }
            (StreamKind::Command, "WheelVoltage") => Some(&["voltage_right_v", "voltage_left_v"]),
            (StreamKind::Wheels, "EncoderTicks") => Some(&["ticks_right", "ticks_left"]),
            (StreamKind::Command | StreamKind::Wheels, "JointState") => {
                match (self.kind, quantity) {
                    (StreamKind::Command, Quantity::Torque) => {
                        Some(&["torque_right_nm", "torque_left_nm"])
                    }
                    (_, Quantity::Speed) => Some(&["speed_right_rad_s", "speed_left_rad_s"]),
                    (StreamKind::Wheels, Quantity::Angle) => {
                        Some(&["angle_right_rad", "angle_left_rad"])
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_round_trips() {
        let text = "format = 1\nstamps = \"log\"\n[robots.r1]\ncommand = \"/cmd_vel\"\n\
            wheels = { topic = \"/joint_states\", right = [\"fr\", \"rr\"], left = \"wl\", quantity = \"speed\" }\n\
            pose = { topic = \"/tf\", parent = \"map\", frame = \"base_link\" }\n";
        let map = TopicMap::parse(text, Path::new("map.toml")).unwrap();
        assert_eq!(map.sources.len(), 3);
        assert_eq!(
            map.to_text().replace("[robots.\"r1\"]", "[robots.r1]"),
            text
        );
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
