//! Scenes: robots, manoeuvre and sensors of a case, before the simulation.

use slipstream_bus::{EffectSpec, RobotModel};

use super::manoeuvre::{CommandKind, Style};
use super::process_noise::ProcessNoise;
use slipstream_trial_plant::{OutsideEffect, Physics};

/// Who decides on the commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Open loop: commands from a list.
    Open,
    /// Closed loop: each robot's controller follows a path.
    Closed,
    /// Closed loop: each robot follows the one ahead.
    Platoon,
}

/// What the camera measures of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Camera {
    /// Nothing.
    Absent,
    /// Position.
    Position,
    /// Position and heading.
    Pose,
}

/// The true robot, as far as it differs from the nominal model.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueRobot {
    /// Effects of the vocabulary that the model lacks.
    pub concealed: Vec<EffectSpec>,
    /// Effect outside the vocabulary.
    pub outside: Option<OutsideEffect>,
    /// What the camera measures of it.
    pub camera: Camera,
}

/// What is recorded beside the command, and known of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recorded {
    /// Whether there are encoders.
    pub wheels: bool,
    /// Whether the inertial sensor has an accelerometer beside its gyroscope.
    pub accelerometer: bool,
    /// Whether the nominal model has masses. Without them it is kinematic.
    pub masses: bool,
}

impl Default for Recorded {
    fn default() -> Self {
        Self {
            wheels: true,
            accelerometer: true,
            masses: true,
        }
    }
}

/// How a recording starts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Start {
    /// At rest.
    #[default]
    Rest,
    /// In the middle of a manoeuvre, rolling at its speeds.
    Moving,
    /// Rolling at half the speed that the wheels turn at, and sliding sideways (m/s).
    Sliding {
        /// To the left.
        sideways_m_s: f64,
    },
    /// At rest under a command of constant size at both wheels (N m, V, rad/s).
    Pressing {
        /// The command.
        command: f64,
        /// How long it lasts (s).
        for_s: f64,
    },
}

/// A scene: robots, manoeuvre, sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Kind of case, for the label.
    pub kind: String,
    /// The nominal model, which the diagnosis gets.
    pub nominal: RobotModel,
    /// The robots `r1`, `r2`, …
    pub robots: Vec<TrueRobot>,
    /// Who decides on the commands.
    pub control: Control,
    /// The kind of command.
    pub command_kind: CommandKind,
    /// Driving style.
    pub style: Style,
    /// Length of the recording (s).
    pub duration_s: f64,
    /// Whether there is an inertial sensor.
    pub imu: bool,
    /// Standard deviation of the random disturbance forces (N); that of the moment is a tenth of it (N m). 0
    /// for none.
    pub disturbance_n: f64,
    /// Longest step of the simulation (s).
    pub step_s: f64,
    /// Process noise on every robot; `None`: none.
    pub noise: Option<ProcessNoise>,
    /// What is recorded beside the command.
    pub recorded: Recorded,
    /// How the recording starts.
    pub start: Start,
    /// Effects removed from the catalogue of the diagnosis.
    pub without: Vec<String>,
    /// Seed of all its random numbers.
    pub seed: u64,
}

impl Scene {
    /// The true model of robot `i`, as far as the vocabulary can express it.
    pub(crate) fn model(&self, i: usize) -> RobotModel {
        let mut model = self.nominal.clone();
        let concealed = &self.robots[i].concealed;
        // A concealed effect replaces that of the nominal model.
        model.effects.retain(|listed| {
            concealed
                .iter()
                .all(|effect| effect.effect != listed.effect)
        });
        model.effects.extend(concealed.iter().cloned());
        model
    }

    /// The nominal model as the diagnosis gets it.
    pub(crate) fn published(&self) -> RobotModel {
        let mut model = self.nominal.clone();
        if !self.recorded.masses {
            let body = &mut model.robot;
            for mass in [
                &mut body.body_mass_kg,
                &mut body.body_yaw_inertia_kg_m2,
                &mut body.wheel_mass_kg,
                &mut body.wheel_spin_inertia_kg_m2,
                &mut body.wheel_yaw_inertia_kg_m2,
                &mut body.com_to_caster_m,
                &mut body.com_height_m,
            ] {
                *mass = None;
            }
            model.motor = None;
        }
        model
    }

    /// Encoder counts per turn of a wheel; 1856 where the nominal model has none.
    pub(crate) fn counts_per_rev(&self) -> f64 {
        let encoder = self.nominal.encoder.as_ref();
        encoder.map_or(1856.0, |encoder| encoder.counts_per_rev)
    }

    /// The true parameters of robot `i`.
    ///
    /// # Errors
    /// As [`Physics::new`].
    pub(crate) fn physics(&self, i: usize) -> Result<Physics, String> {
        let mut physics = Physics::new(&self.model(i))?;
        physics.outside.extend(self.robots[i].outside);
        Ok(physics)
    }

    /// The name of robot `i`.
    pub(crate) fn name(i: usize) -> String {
        format!("r{}", i + 1)
    }
}
