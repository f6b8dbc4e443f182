//! What an effect is: identity, equation, parameters, where it acts and where it shows.

use super::observability::{Manoeuvre, Variable, When};

/// Where in the flow from command to recording an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelSite {
    /// Before the motor: on what the actuators are told.
    Command,
    /// Between motor and wheel.
    DriveTrain,
    /// Where wheels or caster touch the floor.
    Contact,
    /// On the body.
    Body,
    /// Between the robot and a recorded stream.
    Sensor,
    /// Between two robots.
    Link,
}

/// Where an effect shows (`where.channel` of a diagnosis).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Along the body.
    Longitudinal,
    /// Across the body.
    Lateral,
    /// About the vertical.
    Yaw,
    /// Rotation of the right wheel.
    WheelRight,
    /// Rotation of the left wheel.
    WheelLeft,
    /// Camera or motion capture.
    SensorPose,
    /// Encoders.
    SensorWheels,
    /// Inertial measurement.
    SensorImu,
    /// Messages between robots.
    Link,
}

impl Channel {
    /// The channel's name in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Longitudinal => "longitudinal",
            Self::Lateral => "lateral",
            Self::Yaw => "yaw",
            Self::WheelRight => "wheel_right",
            Self::WheelLeft => "wheel_left",
            Self::SensorPose => "sensor_pose",
            Self::SensorWheels => "sensor_wheels",
            Self::SensorImu => "sensor_imu",
            Self::Link => "link",
        }
    }
}

/// What kind of value a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// A number in [`lower`, `upper`].
    Number {
        /// Smallest value that is physical.
        lower: f64,
        /// Largest value that is plausible.
        upper: f64,
        /// Values, spread over what robots show, at which a search looks for the effect.
        probes: &'static [f64],
    },
    /// One of these words.
    Text(&'static [&'static str]),
}

/// What a parameter is, which says how a search treats it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Strength of the effect; at zero the effect is absent.
    Size,
    /// Multiple of a nominal quantity; at one the effect is absent.
    Factor,
    /// Upper limit of a force, torque or speed; at infinity the effect is absent.
    Limit,
    /// Mass that is added to the robot.
    Mass,
    /// Instant on the recording's time axis.
    Time,
    /// Coordinate of a place, on the floor or on the robot.
    Position,
    /// Extent of a place.
    Radius,
    /// Angle that wraps at a full turn.
    Direction,
    /// Name of a part of the robot, as text.
    Name,
}

impl Role {
    /// The role's name in `slipstream effects --json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Size => "size",
            Self::Factor => "factor",
            Self::Limit => "limit",
            Self::Mass => "mass",
            Self::Time => "time",
            Self::Position => "position",
            Self::Radius => "radius",
            Self::Direction => "direction",
            Self::Name => "name",
        }
    }
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// What it is.
    pub role: Role,
    /// The key in `robot.toml`; its end is the unit.
    pub name: &'static str,
    /// The unit, "1" for a plain number.
    pub unit: &'static str,
    /// What it may be.
    pub domain: Domain,
    /// Exactly one of an effect's alternatives is given.
    pub alternative: bool,
}

impl ParameterInfo {
    pub(super) const fn number(
        role: Role,
        name: &'static str,
        unit: &'static str,
        lower: f64,
        upper: f64,
        probes: &'static [f64],
    ) -> Self {
        let domain = Domain::Number {
            lower,
            upper,
            probes,
        };
        Self {
            role,
            name,
            unit,
            domain,
            alternative: false,
        }
    }

    pub(super) const fn text(name: &'static str, words: &'static [&'static str]) -> Self {
        Self {
            role: Role::Name,
            name,
            unit: "text",
            domain: Domain::Text(words),
            alternative: false,
        }
    }

    pub(super) const fn or(self) -> Self {
        Self {
            alternative: true,
            ..self
        }
    }
}

/// What an effect is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Info {
    /// Identity in the vocabulary.
    pub id: &'static str,
    /// What it is, in a line.
    pub summary: &'static str,
    /// Its equation, in the paper's symbols.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// Where it acts.
    pub site: ModelSite,
    /// Where it shows.
    pub channels: &'static [Channel],
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
    /// It may occur more than once.
    pub repeats: bool,
    /// A model without masses can express it.
    pub kinematic: bool,
    /// When it acts.
    pub acts: When,
    /// The same for a person, without its numbers.
    pub condition: &'static str,
    /// Where its force or moment tells most of it, and over what.
    pub follows: &'static [(Channel, Variable)],
    /// What shows it best.
    pub manoeuvre: Manoeuvre,
}

impl Info {
    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&'static ParameterInfo> {
        self.parameters.iter().find(|known| known.name == name)
    }
}
