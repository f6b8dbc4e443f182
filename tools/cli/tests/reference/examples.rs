//! One example of every effect: its size, what is commanded and what is shown. They stand in `examples.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;
use slipstream_bus::{EffectSpec, Parameter};
use slipstream_sim::Command;

/// Instants that differ by less are one (s).
const SAME_S: f64 = 1e-9;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    courses: BTreeMap<String, Course>,
    effects: BTreeMap<String, Example>,
}

/// An effect at work.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Example {
    /// The effect: its key.
    #[serde(skip)]
    pub(crate) effect: String,
    course: String,
    pub(crate) shows: Shown,
    /// Whether both robots drive on the floor of the paper instead of rolling without slip.
    #[serde(default)]
    pub(crate) slips: bool,
    parameters: toml::Table,
}

/// Commands over time.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Course {
    words: String,
    pub(crate) length_s: f64,
    /// Begin (s) and torques of the right and of the left wheel (N m).
    #[serde(default)]
    torque_nm: Vec<[f64; 3]>,
    /// Begin (s), speed (m/s) and turn rate (rad/s).
    #[serde(default)]
    twist: Vec<[f64; 3]>,
}

static CONTENT: LazyLock<Content> = LazyLock::new(|| {
    let read = toml::from_str(include_str!("examples.toml"));
    let mut content: Content = read.unwrap_or_else(|error| panic!("examples.toml: {error}"));
    for (effect, example) in &mut content.effects {
        example.effect.clone_from(effect);
    }
    content
});

/// All examples, by effect.
pub(crate) fn all() -> impl ExactSizeIterator<Item = &'static Example> {
    CONTENT.effects.values()
}

/// The example of an effect.
pub(crate) fn of(effect: &str) -> &'static Example {
    let found = CONTENT.effects.get(effect);
    found.unwrap_or_else(|| panic!("{effect} has no example"))
}

impl Course {
    /// Command at a time (s).
    pub(crate) fn command(&self, t_s: f64) -> Command {
        let held = |entries: &[[f64; 3]]| {
            let begun = entries.iter().take_while(|own| own[0] <= t_s + SAME_S);
            begun.last().copied()
        };
        if let Some([_, right_nm, left_nm]) = held(&self.torque_nm) {
            Command::Torque { right_nm, left_nm }
        } else {
            let [_, v_m_s, w_rad_s] = held(&self.twist).unwrap_or_default();
            Command::Twist { v_m_s, w_rad_s }
        }
    }
}

/// What a picture shows.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Shown {
    Speed,
    TurnRate,
    EncoderSpeed,
    Path,
    SeenPath,
    OdometryPath,
    SeenX,
    EncoderAngle,
    Gyro,
    MessageX,
}

impl Shown {
    /// Names of the axes, with units.
    pub(crate) fn axes(self) -> [&'static str; 2] {
        let t = "time (s)";
        let stamp = "time stamp (s)";
        match self {
            Self::Speed => [t, "speed (m/s)"],
            Self::TurnRate => [t, "turn rate (rad/s)"],
            Self::EncoderSpeed => [t, "speed of the right encoder (rad/s)"],
            Self::Path => ["x (m)", "y (m)"],
            Self::SeenPath => ["x in pose.csv (m)", "y in pose.csv (m)"],
            Self::OdometryPath => ["x by odometry (m)", "y by odometry (m)"],
            Self::SeenX => [stamp, "x in pose.csv (m)"],
            Self::EncoderAngle => [stamp, "angle of the right encoder (rad)"],
            Self::Gyro => [stamp, "turn rate in imu.csv (rad/s)"],
            Self::MessageX => ["time of sending (s)", "x in the message (m)"],
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Speed => "speed along the body",
            Self::TurnRate => "turn rate",
            Self::EncoderSpeed => "speed of the right wheel by its encoder",
            Self::Path => "path of the centre of mass",
            Self::SeenPath => "path by the pose sensor",
            Self::OdometryPath => "path by the encoders",
            Self::SeenX => "position by the pose sensor",
            Self::EncoderAngle => "angle of the right wheel by its encoder",
            Self::Gyro => "turn rate by the gyro",
            Self::MessageX => "position of the robot in front by its messages",
        }
    }
}

impl Example {
    /// The effect as a model lists it.
    pub(crate) fn spec(&self) -> EffectSpec {
        let parameters = self.parameters.iter();
        EffectSpec {
            effect: self.effect.clone(),
            parameters: parameters
                .map(|(name, value)| (name.clone(), parameter(value)))
                .collect(),
        }
    }

    pub(crate) fn course(&self) -> &'static Course {
        let found = CONTENT.courses.get(&self.course);
        found.unwrap_or_else(|| panic!("examples.toml has no course {}", self.course))
    }

    /// What the picture shows, in words.
    pub(crate) fn caption(&self) -> String {
        format!("{}, {}", self.shows.words(), self.course().words)
    }
}

fn parameter(value: &toml::Value) -> Parameter {
    match value {
        toml::Value::Float(number) => Parameter::Number(*number),
        toml::Value::String(text) => Parameter::Text(text.clone()),
        toml::Value::Array(all) => {
            Parameter::List(all.iter().filter_map(toml::Value::as_float).collect())
        }
        other => panic!("examples.toml: {other} is no number, text or list"),
    }
}
