//! Description of an effect: id, equation, parameters, where it acts and where it is observed.
//!
//! A description starts from what effects of its kind have in common, such as [`Info::command`], and
//! states what is its own by the methods named as the fields.

use super::observability::{Manoeuvre, Variable, When};
use super::parameter::{Domain, ParameterInfo};

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

/// Motion of a body and both of its wheels.
pub(super) const ALL_MOTION: &[Channel] = &[
    Channel::Longitudinal,
    Channel::Lateral,
    Channel::Yaw,
    Channel::WheelRight,
    Channel::WheelLeft,
];

/// Motion in which the torques of the wheels show.
const DRIVEN_MOTION: &[Channel] = &[
    Channel::Longitudinal,
    Channel::Yaw,
    Channel::WheelRight,
    Channel::WheelLeft,
];

/// A function of the commands of the wheels.
pub(super) const WHEEL_COMMANDS: &[(Channel, Variable)] = &[
    (Channel::WheelRight, Variable::Command),
    (Channel::WheelLeft, Variable::Command),
];

/// A function of the speeds of the wheels.
const WHEEL_SPEEDS: &[(Channel, Variable)] = &[
    (Channel::WheelRight, Variable::Speed),
    (Channel::WheelLeft, Variable::Speed),
];

/// A function of speed and yaw rate.
pub(super) const TWIST: &[(Channel, Variable)] = &[
    (Channel::Longitudinal, Variable::Speed),
    (Channel::Yaw, Variable::TurnRate),
];

/// Descriptions by kind.
impl Info {
    /// Change of the wheels' commands. Every robot has commands.
    pub(super) const fn command(id: &'static str, summary: &'static str) -> Self {
        Self::new(id, summary, ModelSite::Command, Manoeuvre::Steps)
            .channels(DRIVEN_MOTION)
            .follows(WHEEL_COMMANDS)
            .kinematic()
    }

    /// Torque against the rotation of the wheels.
    pub(super) const fn axle_torque(id: &'static str, summary: &'static str) -> Self {
        Self::new(id, summary, ModelSite::DriveTrain, Manoeuvre::LiftedWheels)
            .channels(DRIVEN_MOTION)
            .follows(WHEEL_SPEEDS)
    }

    /// What lies between the motors, which the encoders count, and the floor.
    pub(super) const fn transmission(id: &'static str, summary: &'static str) -> Self {
        Self::new(id, summary, ModelSite::DriveTrain, Manoeuvre::Steps)
            .channels(&[
                Channel::Longitudinal,
                Channel::Yaw,
                Channel::WheelRight,
                Channel::WheelLeft,
                Channel::SensorWheels,
            ])
            .follows(WHEEL_COMMANDS)
    }

    /// Force at the contacts with the floor.
    pub(super) const fn contact(id: &'static str, summary: &'static str) -> Self {
        Self::new(id, summary, ModelSite::Contact, Manoeuvre::UntilItSlips).channels(ALL_MOTION)
    }

    /// Change of turns by the contacts with the floor.
    pub(super) const fn turning(id: &'static str, summary: &'static str) -> Self {
        Self::new(id, summary, ModelSite::Contact, Manoeuvre::SpinInPlace)
            .channels(&[Channel::Yaw])
            .condition("whenever it turns")
            .follows(&[(Channel::Yaw, Variable::TurnRate)])
    }

    /// Force on the body against its motion.
    pub(super) const fn drag(id: &'static str, summary: &'static str) -> Self {
        Self::new(id, summary, ModelSite::Body, Manoeuvre::CoastDown)
            .channels(&[
                Channel::Longitudinal,
                Channel::WheelRight,
                Channel::WheelLeft,
            ])
            .condition("whenever it moves")
            .follows(&[(Channel::Longitudinal, Variable::Speed)])
    }

    /// Force on the body, or mass, at a place of its own.
    pub(super) const fn body(
        id: &'static str,
        summary: &'static str,
        manoeuvre: Manoeuvre,
    ) -> Self {
        Self::new(id, summary, ModelSite::Body, manoeuvre).channels(&[
            Channel::Longitudinal,
            Channel::Lateral,
            Channel::Yaw,
        ])
    }

    /// Error of recorded streams. Every robot has streams.
    pub(super) const fn sensor(
        id: &'static str,
        summary: &'static str,
        channels: &'static [Channel],
    ) -> Self {
        Self::new(id, summary, ModelSite::Sensor, Manoeuvre::SharpStarts)
            .channels(channels)
            .kinematic()
    }

    /// What acts always, is listed once and needs masses.
    pub(super) const fn new(
        id: &'static str,
        summary: &'static str,
        site: ModelSite,
        manoeuvre: Manoeuvre,
    ) -> Self {
        Self {
            id,
            summary,
            equation: "",
            source: "",
            site,
            channels: &[],
            parameters: &[],
            repeats: false,
            kinematic: false,
            acts: When::Always,
            condition: "always",
            follows: &[],
            manoeuvre,
        }
    }
}

/// What an effect has of its own.
impl Info {
    pub(super) const fn equation(self, equation: &'static str) -> Self {
        Self { equation, ..self }
    }

    pub(super) const fn source(self, source: &'static str) -> Self {
        Self { source, ..self }
    }

    pub(super) const fn channels(self, channels: &'static [Channel]) -> Self {
        Self { channels, ..self }
    }

    pub(super) const fn parameters(self, parameters: &'static [ParameterInfo]) -> Self {
        Self { parameters, ..self }
    }

    pub(super) const fn repeats(self) -> Self {
        Self {
            repeats: true,
            ..self
        }
    }

    pub(super) const fn kinematic(self) -> Self {
        Self {
            kinematic: true,
            ..self
        }
    }

    pub(super) const fn acts(self, acts: When) -> Self {
        Self { acts, ..self }
    }

    pub(super) const fn condition(self, condition: &'static str) -> Self {
        Self { condition, ..self }
    }

    pub(super) const fn follows(self, follows: &'static [(Channel, Variable)]) -> Self {
        Self { follows, ..self }
    }

    pub(super) const fn manoeuvre(self, manoeuvre: Manoeuvre) -> Self {
        Self { manoeuvre, ..self }
    }
}
