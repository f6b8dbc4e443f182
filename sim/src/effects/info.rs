//! Description of an effect: id, equation, parameters, where it acts and where it is observed.

use super::observability::{Manoeuvre, Variable, When};

/// Part of the model that an effect changes, in the order from command to recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelSite {
    /// The command, before the motor.
    Command,
    /// The drive train, between motor and wheel.
    DriveTrain,
    /// The contacts of wheels and caster with the floor.
    Contact,
    /// The body.
    Body,
    /// A sensor, between the robot and a recorded stream.
    Sensor,
    /// A link between two robots.
    Link,
}

/// Direction of motion, or recorded stream, in which an effect is observed (`where.channel` of a
/// diagnosis).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Motion along the body.
    Longitudinal,
    /// Motion across the body.
    Lateral,
    /// Rotation about the vertical.
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

/// Set of values that a parameter may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// A number in [`lower`, `upper`].
    Number {
        /// Smallest physical value.
        lower: f64,
        /// Largest plausible value.
        upper: f64,
        /// Values spread over what robots show, from which a search for the effect starts.
        probes: &'static [f64],
    },
    /// One of these words.
    Text(&'static [&'static str]),
    /// Numbers in [`lower`, `upper`], from 1 to [`LIST_MAX`] of them. All lists of an effect have the
    /// same length.
    List {
        /// Smallest value of each.
        lower: f64,
        /// Largest value of each.
        upper: f64,
        /// Whether each number is larger than the one before.
        increasing: bool,
    },
}

/// Largest number of values in a list.
pub const LIST_MAX: usize = 64;

/// Meaning of a parameter, which determines how a search treats it.
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
    /// Time on the recording's time axis.
    Time,
    /// Coordinate of a point on the floor or on the robot.
    Position,
    /// Radius of a part of the floor.
    Radius,
    /// Angle that wraps at a full turn.
    Direction,
    /// Name of a part of the robot, as text.
    Name,
    /// Values of a driver at which a table has entries.
    Knots,
    /// Entries of a table.
    Entries,
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
            Self::Knots => "knots",
            Self::Entries => "entries",
        }
    }
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// Its meaning.
    pub role: Role,
    /// Its key in `robot.toml`, which ends with the unit if it has one.
    pub name: &'static str,
    /// Its unit; "1" for a plain number.
    pub unit: &'static str,
    /// The values it may take.
    pub domain: Domain,
    /// Whether it is one of several alternatives, of which a model gives exactly one.
    pub alternative: bool,
    /// Whether a model may leave it out: it is then 0.
    pub optional: bool,
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
            optional: false,
        }
    }

    pub(super) const fn text(name: &'static str, words: &'static [&'static str]) -> Self {
        Self {
            role: Role::Name,
            name,
            unit: "text",
            domain: Domain::Text(words),
            alternative: false,
            optional: false,
        }
    }

    pub(super) const fn list(
        role: Role,
        name: &'static str,
        unit: &'static str,
        [lower, upper]: [f64; 2],
    ) -> Self {
        Self {
            role,
            name,
            unit,
            domain: Domain::List {
                lower,
                upper,
                increasing: matches!(role, Role::Knots),
            },
            alternative: false,
            optional: false,
        }
    }

    /// The same parameter as one of several alternatives.
    pub(super) const fn as_alternative(self) -> Self {
        Self {
            alternative: true,
            ..self
        }
    }

    /// The same parameter, which is 0 where it is left out.
    pub(super) const fn as_optional(self) -> Self {
        Self {
            optional: true,
            ..self
        }
    }
}

/// Description of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Info {
    /// Its id: the key in `robot.toml` and in all answers.
    pub id: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Its equation, in the paper's symbols.
    pub equation: &'static str,
    /// Source of the equation.
    pub source: &'static str,
    /// Part of the model that it changes.
    pub site: ModelSite,
    /// Channels in which it is observed.
    pub channels: &'static [Channel],
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
    /// Whether a model may list it more than once.
    pub repeats: bool,
    /// Whether a kinematic model, without masses, can include it.
    pub kinematic: bool,
    /// When it acts, for a search.
    pub acts: When,
    /// When it acts, for people, without numbers.
    pub condition: &'static str,
    /// Channels in which it appears as a force or moment that is a function of a variable.
    pub follows: &'static [(Channel, Variable)],
    /// The manoeuvre that shows it best.
    pub manoeuvre: Manoeuvre,
}

impl Info {
    /// The parameter with this name, if there is one.
    pub fn parameter(&self, name: &str) -> Option<&'static ParameterInfo> {
        self.parameters.iter().find(|known| known.name == name)
    }

    /// Whether it is a table: some of its parameters are lists.
    pub fn is_table(&self) -> bool {
        let mut parameters = self.parameters.iter();
        parameters.any(|known| matches!(known.domain, Domain::List { .. }))
    }
}
