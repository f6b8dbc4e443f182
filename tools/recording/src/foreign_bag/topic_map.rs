//! Which topic of a foreign bag is which stream: read from a small TOML, or guessed and printed.
//!
//! ```toml
//! format = 1
//! stamps = "message"              # or "log": the time of logging instead of the message's stamp
//! [robots.r1]
//! command = "/cmd_vel"
//! wheels = { topic = "/joint_states", right = "wheel_right_joint", left = "wheel_left_joint",
//!            quantity = "angle" } # or "speed"; for a command also "torque"
//! odometry = "/odom"
//! pose = { topic = "/tf", frame = "base_link" }
//! imu = "/imu"
//! ```

use std::fmt::Write as _;
use std::path::Path;

use crate::decode::Pick;
use crate::error::{Result, Unusable};
use crate::recording::is_robot_name;
use crate::table::StreamKind;
use crate::toml_files::{Entry, File, read_text};

/// Which topic of a bag is which stream.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TopicMap {
    /// Take the time of logging, not the stamp in the message.
    pub(crate) log_times: bool,
    pub(crate) sources: Vec<Source>,
}

/// One stream and where it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Source {
    pub(crate) robot: String,
    pub(crate) kind: StreamKind,
    pub(crate) topic: String,
    pub(crate) pick: Pick,
    pub(crate) quantity: Option<Quantity>,
}

/// Which of its three lists a joint state gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Angle,
    Speed,
    Torque,
}

const QUANTITIES: [(&str, Quantity); 3] = [
    ("angle", Quantity::Angle),
    ("speed", Quantity::Speed),
    ("torque", Quantity::Torque),
];

impl TopicMap {
    /// Reads a map.
    ///
    /// # Errors
    /// Anything that is not as the description of the format says, with file and line.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::parse(&read_text(path)?, path)?)
    }

    /// Parses the text of a map; `path` is only for errors.
    ///
    /// # Errors
    /// As [`TopicMap::read`].
    pub fn parse(text: &str, path: &Path) -> std::result::Result<Self, Unusable> {
        let file = File { path, text };
        let table = file.parse()?;
        let root = file.root(&table);
        root.format_is_1()?;
        root.only(&["format", "stamps", "robots"])?;
        let mut map = Self::default();
        if let Some(stamps) = root.get("stamps") {
            map.log_times = match stamps.text()? {
                "message" => false,
                "log" => true,
                _ => return Err(stamps.error("is neither", "write \"message\" or \"log\"")),
            };
        }
        for (robot, entry) in root.require("robots")?.section()?.entries() {
            if !is_robot_name(robot) {
                return Err(entry.error("is no robot's name", "use letters, digits, `_` and `-`"));
            }
            let section = entry.section()?;
            section.only(&StreamKind::ALL.map(StreamKind::name))?;
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

    /// The map as TOML, to be saved and mended.
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
            }
            let _ = writeln!(text, "{} = {}", source.kind.name(), source.to_text());
        }
        text
    }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn parse_source(
    robot: &str,
    kind: StreamKind,
    entry: &Entry<'_>,
) -> std::result::Result<Source, Unusable> {
    let mut source = Source {
        robot: robot.to_owned(),
        kind,
        topic: String::new(),
        pick: Pick::default(),
        quantity: None,
    };
    if let Ok(topic) = entry.text() {
        source.topic = topic.to_owned();
        return Ok(source);
    }
    let section = entry.section()?;
    section.only(&["topic", "frame", "right", "left", "quantity"])?;
    source.topic = section.require("topic")?.text()?.to_owned();
    if let Some(frame) = section.get("frame") {
        source.pick.frame = Some(frame.text()?.to_owned());
    }
    for (joint, key) in source.pick.joints.iter_mut().zip(["right", "left"]) {
        if let Some(name) = section.get(key) {
            *joint = name.text()?.to_owned();
        }
    }
    if let Some(entry) = section.get("quantity") {
        let word = entry.text()?;
        let known = QUANTITIES.iter().find(|(name, _)| *name == word);
        let Some((_, quantity)) = known else {
            return Err(entry.error("is no quantity", "write angle, speed or torque"));
        };
        source.quantity = Some(*quantity);
    }
    Ok(source)
}

impl Source {
    fn to_text(&self) -> String {
        let topic = quoted(&self.topic);
        let mut keys = vec![format!("topic = {topic}")];
        if let Some(frame) = &self.pick.frame {
            keys.push(format!("frame = {}", quoted(frame)));
        }
        if let Some(quantity) = self.quantity {
            let [right, left] = &self.pick.joints;
            keys.push(format!(
                "right = {}, left = {}",
                quoted(right),
                quoted(left)
            ));
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

    /// The columns of the stream that a message of this type fills, if it can be such a stream.
    pub(crate) fn columns(&self, schema: &str) -> Option<&'static [&'static str]> {
        const TWIST: &[&str] = &["v_m_s", "w_rad_s"];
        const POSE: &[&str] = &["x_m", "y_m", "yaw_rad"];
        let quantity = self.quantity.unwrap_or(match self.kind {
            StreamKind::Command => Quantity::Torque,
            _ => Quantity::Angle,
        });
        let name = schema.rsplit('/').next().unwrap_or_default();
        match (self.kind, name) {
            (StreamKind::Command, "Twist" | "TwistStamped") => Some(TWIST),
            (StreamKind::Odometry, "Twist" | "TwistStamped" | "Odometry") => Some(TWIST),
            (
                StreamKind::Pose,
                "Pose" | "PoseStamped" | "PoseWithCovarianceStamped" | "Odometry" | "TFMessage",
            ) => Some(POSE),
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
    fn a_map_is_read_back_as_written() {
        let text = "format = 1\nstamps = \"log\"\n[robots.r1]\ncommand = \"/cmd_vel\"\n\
            wheels = { topic = \"/joint_states\", right = \"wr\", left = \"wl\", quantity = \"speed\" }\n\
            pose = { topic = \"/tf\", frame = \"base_link\" }\n";
        let map = TopicMap::parse(text, Path::new("map.toml")).unwrap();
        assert_eq!(map.sources.len(), 3);
        assert_eq!(
            map.to_text().replace("[robots.\"r1\"]", "[robots.r1]"),
            text
        );
    }

    #[test]
    fn a_map_with_an_unknown_key_names_its_line() {
        let text = "format = 1\n[robots.r1]\ncamera = \"/cam\"\n";
        let error = TopicMap::parse(text, Path::new("map.toml")).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("map.toml:3: robots.r1.camera is no key")
        );
    }
}
