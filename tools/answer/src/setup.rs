//! How a machine is told and seen, as far as it decides what to do about a finding.

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, PosePoint, Robot as Recorded};

/// What the commands of a machine are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    /// It was recorded without commands.
    Nothing,
    /// Speed and turn rate of the body: wheel speeds are computed behind the recording.
    Twist,
    /// Wheel speeds.
    WheelSpeed,
    /// Torques at the wheels.
    Torque,
    /// Voltages of the motors.
    Voltage,
}

impl Told {
    /// Whether a speed controller stands between commands and motors.
    pub(crate) fn is_speed(self) -> bool {
        matches!(self, Self::Twist | Self::WheelSpeed)
    }

    /// What is commanded of one wheel, in a word.
    pub(crate) fn of_wheel(self) -> &'static str {
        match self {
            Self::Torque => "torque",
            Self::Voltage => "voltage",
            _ => "speed",
        }
    }
}

/// How a machine is told and seen.
pub(crate) struct Setup<'a> {
    /// Its improved model.
    pub(crate) model: &'a RobotModel,
    /// What its commands are.
    pub(crate) told: Told,
    /// Whether it runs ROS, and so has the parameters of its packages.
    pub(crate) has_ros: bool,
    /// Whether wheel encoders were recorded.
    pub(crate) has_wheels: bool,
    /// Nominal counts per turn of a wheel, where they are known.
    pub(crate) counts_per_turn: Option<f64>,
    /// From the middle of the axle forward to the point whose pose is declared (m).
    pub(crate) declared_ahead_m: f64,
}

impl<'a> Setup<'a> {
    /// The setup of the robot `name`; `None` if no recording has it.
    pub(crate) fn of(
        name: &str,
        model: &'a RobotModel,
        recordings: &[Recording],
    ) -> Option<Setup<'a>> {
        let robot = recordings.iter().find_map(|own| own.robot(name))?;
        let axle = robot.pose_point == Some(PosePoint::Axle);
        let ahead_m = model.robot.com_to_axle_m.filter(|_| !axle);
        Some(Setup {
            model,
            told: told(robot),
            has_ros: recordings.iter().any(Recording::is_of_ros),
            has_wheels: robot.wheels.is_some(),
            counts_per_turn: robot.counts_per_rev(Some(model)),
            declared_ahead_m: ahead_m.unwrap_or(0.0),
        })
    }
}

impl Setup<'_> {
    /// Where the program is that talks to motors and encoders, in words.
    pub(crate) fn driver(&self) -> &'static str {
        match self.has_ros {
            true => "in the hardware interface",
            false => "in the program that reads the encoders and drives the motors",
        }
    }
}

fn told(robot: &Recorded) -> Told {
    match robot.command.as_ref().map(|own| &own.values) {
        None => Told::Nothing,
        Some(Command::Twist { .. }) => Told::Twist,
        Some(Command::WheelSpeed { .. }) => Told::WheelSpeed,
        Some(Command::Torque { .. }) => Told::Torque,
        Some(Command::Voltage { .. }) => Told::Voltage,
    }
}
