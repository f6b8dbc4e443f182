//! A stream of a topic map: its topic, what of the messages is read, and which columns that gives.

use slipstream_bus::InputError;

use crate::decode::MessageSelector;
use crate::table::StreamKind;
use crate::toml_files::{Entry, Section, quoted};

/// A stream and where it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Source {
    pub(super) robot: String,
    pub(super) kind: StreamKind,
    /// The topic; if the wheels have one each, that of the right one.
    pub(super) topic: String,
    /// Of joint states the joints, of transforms the frames, of other messages the fields of wheels.
    pub(super) selector: MessageSelector,
    /// Where wheels have a topic each: right and left.
    pub(super) apart: Option<[Place; 2]>,
    /// Whether the signs of the right and left wheel are turned.
    pub(super) reversed: [bool; 2],
    /// What joints or numbers are. Without it, torque for commands and angle for wheels.
    pub(super) quantity: Option<Quantity>,
}

/// A number in a topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) topic: String,
    /// Path of the field, such as `data` or `motor[1].ticks`.
    pub(super) field: String,
}

/// What numbers of wheels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Angle,
    Speed,
    Torque,
    Ticks,
    Voltage,
}

/// The words for the quantities in a map.
const QUANTITIES: [(&str, Quantity); 5] = [
    ("angle", Quantity::Angle),
    ("speed", Quantity::Speed),
    ("torque", Quantity::Torque),
    ("ticks", Quantity::Ticks),
    ("voltage", Quantity::Voltage),
];

/// The words for sides whose sign is turned, right and left.
const REVERSED: [(&str, [bool; 2]); 3] = [
    ("right", [true, false]),
    ("left", [false, true]),
    ("both", [true, true]),
];

/// Keys of the two sides.
const SIDES: [&str; 2] = ["right", "left"];

type Result<T> = std::result::Result<T, InputError>;

impl Source {
    /// A stream that a topic holds as a whole.
    pub(super) fn of(robot: &str, kind: StreamKind, topic: &str) -> Self {
        Self {
            robot: robot.to_owned(),
            kind,
            topic: topic.to_owned(),
            selector: MessageSelector::default(),
            apart: None,
            reversed: [false; 2],
            quantity: None,
        }
    }

    /// Parses the value of a stream's key: a topic, or a table with further keys.
    pub(super) fn parse(robot: &str, kind: StreamKind, entry: &Entry<'_>) -> Result<Self> {
        if let Ok(topic) = entry.text() {
            return Ok(Self::of(robot, kind, topic));
        }
        let section = entry.section()?;
        section.allow_only(&[
            "topic", "parent", "frame", "right", "left", "quantity", "reversed",
        ])?;
        let mut source = Self::of(robot, kind, "");
        source.quantity = quantity(&section)?;
        source.reversed = reversed(&section)?;
        let right = section.get("right");
        if right.is_some_and(|right| right.section().is_ok()) {
            section.allow_only(&["right", "left", "quantity", "reversed"])?;
            if source.quantity.is_none() {
                section.require("quantity")?;
            }
            let [right, left] = SIDES.map(|side| place(&section.require(side)?));
            let places = [right?, left?];
            source.topic.clone_from(&places[0].topic);
            source.apart = Some(places);
            return Ok(source);
        }
        section
            .require("topic")?
            .text()?
            .clone_into(&mut source.topic);
        let selector = &mut source.selector;
        for (key, name) in [
            ("frame", &mut selector.frame),
            ("parent", &mut selector.parent),
        ] {
            if let Some(entry) = section.get(key) {
                *name = Some(entry.text()?.to_owned());
            }
        }
        for (joints, key) in selector.joints.iter_mut().zip(SIDES) {
            if let Some(entry) = section.get(key) {
                *joints = names(&entry)?;
                if joints.len() > 1 && source.quantity == Some(Quantity::Ticks) {
                    let remedy = "name one of this side: a mean of counters is no counter";
                    return Err(entry.error("has several names", remedy));
                }
            }
        }
        Ok(source)
    }

    /// The value of the stream's key in a map.
    pub(super) fn to_text(&self) -> String {
        let topic = quoted(&self.topic);
        let mut keys = Vec::new();
        match &self.apart {
            None => keys.push(format!("topic = {topic}")),
            Some(places) => keys.extend(SIDES.iter().zip(places).map(|(side, place)| {
                let [topic, field] = [&place.topic, &place.field].map(|text| quoted(text));
                format!("{side} = {{ topic = {topic}, field = {field} }}")
            })),
        }
        if let Some(parent) = &self.selector.parent {
            keys.push(format!("parent = {}", quoted(parent)));
        }
        if let Some(frame) = &self.selector.frame {
            keys.push(format!("frame = {}", quoted(frame)));
        }
        if let Some(quantity) = self.quantity {
            if self.apart.is_none() {
                let [right, left] = self.selector.joints.each_ref().map(|side| in_list(side));
                keys.push(format!("right = {right}, left = {left}"));
            }
            let word = QUANTITIES.iter().find(|(_, known)| *known == quantity);
            keys.push(format!(
                "quantity = \"{}\"",
                word.map_or("", |(word, _)| word)
            ));
        }
        if let Some((word, _)) = REVERSED.iter().find(|(_, own)| *own == self.reversed) {
            keys.push(format!("reversed = \"{word}\""));
        }
        if keys.len() == 1 {
            return topic;
        }
        format!("{{ {} }}", keys.join(", "))
    }

    /// The topics that the map names for it.
    pub(super) fn topics(&self) -> Vec<&str> {
        match &self.apart {
            None => vec![&self.topic],
            Some(places) => places.iter().map(|place| place.topic.as_str()).collect(),
        }
    }

    /// The columns of the stream that a message of this type provides by its meaning; `None` if it cannot provide the stream.
    pub(super) fn columns(&self, schema: &str) -> Option<&'static [&'static str]> {
        const TWIST: &[&str] = &["v_m_s", "w_rad_s"];
        const POSE: &[&str] = &["x_m", "y_m", "yaw_rad"];
        let name = schema.rsplit('/').next().unwrap_or_default();
        match (self.kind, name) {
            (StreamKind::Command, "Twist" | "TwistStamped" | "struct:ChassisSpeeds") => Some(TWIST),
            (
                StreamKind::Odometry,
                "Twist"
                | "TwistStamped"
                | "TwistWithCovarianceStamped"
                | "Odometry"
                | "PoseStamped"
                | "PoseWithCovarianceStamped"
                | "struct:ChassisSpeeds"
                | "struct:Pose2d",
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
            (StreamKind::Command, "WheelVoltage") => self.of_wheels(Quantity::Voltage),
            (StreamKind::Wheels, "EncoderTicks") => self.of_wheels(Quantity::Ticks),
            (StreamKind::Command, "JointState") => {
                let quantity = self.quantity.unwrap_or(Quantity::Torque);
                let is_list = matches!(quantity, Quantity::Torque | Quantity::Speed);
                is_list.then(|| self.of_wheels(quantity))?
            }
            (StreamKind::Wheels, "JointState") => {
                let quantity = self.quantity.unwrap_or(Quantity::Angle);
                (quantity != Quantity::Ticks).then(|| self.of_wheels(quantity))?
            }
            (StreamKind::Wheels, "TFMessage" | "tfMessage") => {
                let quantity = self.quantity.unwrap_or(Quantity::Angle);
                (quantity == Quantity::Angle).then(|| self.of_wheels(quantity))?
            }
            _ => None,
        }
    }

    /// The columns of numbers in any messages; `None` if the stream has no such quantity.
    pub(super) fn columns_of_fields(&self) -> Option<&'static [&'static str]> {
        self.of_wheels(self.quantity?)
    }

    /// The columns of a quantity of two wheels.
    fn of_wheels(&self, quantity: Quantity) -> Option<&'static [&'static str]> {
        match (self.kind, quantity) {
            (StreamKind::Command, Quantity::Torque) => Some(&["torque_right_nm", "torque_left_nm"]),
            (StreamKind::Command, Quantity::Voltage) => {
                Some(&["voltage_right_v", "voltage_left_v"])
            }
            (StreamKind::Command | StreamKind::Wheels, Quantity::Speed) => {
                Some(&["speed_right_rad_s", "speed_left_rad_s"])
            }
            (StreamKind::Wheels, Quantity::Angle) => Some(&["angle_right_rad", "angle_left_rad"]),
            (StreamKind::Wheels, Quantity::Ticks) => Some(&["ticks_right", "ticks_left"]),
            _ => None,
        }
    }
}

/// The quantity that a table names, if any.
fn quantity(section: &Section<'_>) -> Result<Option<Quantity>> {
    let Some(entry) = section.get("quantity") else {
        return Ok(None);
    };
    let word = entry.text()?;
    match QUANTITIES.iter().find(|(name, _)| *name == word) {
        Some((_, quantity)) => Ok(Some(*quantity)),
        None => {
            let remedy = "write angle, speed, ticks, torque or voltage";
            Err(entry.error("is not a quantity", remedy))
        }
    }
}

/// The sides whose sign is turned, right and left.
fn reversed(section: &Section<'_>) -> Result<[bool; 2]> {
    let Some(entry) = section.get("reversed") else {
        return Ok([false; 2]);
    };
    let word = entry.text()?;
    let known = REVERSED.iter().find(|(name, _)| *name == word);
    let sides = known.map(|(_, sides)| *sides);
    sides.ok_or_else(|| entry.error("is no side", "write right, left or both"))
}

/// A topic and its field.
fn place(entry: &Entry<'_>) -> Result<Place> {
    let section = entry.section()?;
    section.allow_only(&["topic", "field"])?;
    Ok(Place {
        topic: section.require("topic")?.text()?.to_owned(),
        field: section.require("field")?.text()?.to_owned(),
    })
}

/// The names of a side: one, or a list.
fn names(entry: &Entry<'_>) -> Result<Vec<String>> {
    let list = entry.elements();
    let list = list.iter().map(|name| Ok(name.text()?.to_owned()));
    let list: Vec<String> = list.collect::<Result<_>>()?;
    match list.is_empty() {
        true => Err(entry.error("names no joint", "name the joints of this side")),
        false => Ok(list),
    }
}

/// One name, or a list of names.
fn in_list(names: &[String]) -> String {
    match names {
        [name] => quoted(name),
        _ => {
            let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
            format!("[{}]", names.join(", "))
        }
    }
}
