//! What a case is made of, before anything moves.

use slipstream_bus::{EffectSpec, RobotModel};

use super::manoeuvre::{Style, Told};
use crate::plant::{Physics, Strange};

/// Who decides on the commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Played from a list.
    Open,
    /// The robot's own controller, on a path of its own.
    Closed,
    /// The same, each robot behind the one ahead.
    Platoon,
}

/// What a camera sees of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Eye {
    /// Nothing.
    Blind,
    /// Its place.
    Place,
    /// Its place and heading.
    Pose,
}

/// One robot as it really is, beside the nominal model.
#[derive(Debug, Clone, PartialEq)]
pub struct Actual {
    /// Effects of the vocabulary that the model leaves out.
    pub hidden: Vec<EffectSpec>,
    /// What the vocabulary does not hold.
    pub strange: Option<Strange>,
    /// The camera's view of it.
    pub eye: Eye,
}

/// A scene: robots, what they do, what sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// What drew it.
    pub kind: String,
    /// The model that the diagnosis gets.
    pub nominal: RobotModel,
    /// The robots, `r1` and on.
    pub robots: Vec<Actual>,
    /// Who decides.
    pub control: Control,
    /// What is told.
    pub told: Told,
    /// How they are driven.
    pub style: Style,
    /// How long (s).
    pub duration_s: f64,
    /// Whether there is an inertial sensor.
    pub imu: bool,
    /// Deviation of forces that wander (N; the moment's is a tenth, in N m); 0 without.
    pub wandering_n: f64,
    /// Longest step of the simulation (s).
    pub step_s: f64,
    /// Effects that the diagnosis gets its catalogue without.
    pub without: Vec<String>,
    /// Seed of everything that chance decides in it.
    pub seed: u64,
}

impl Scene {
    /// The model with all that robot `i` really has, as far as the vocabulary holds it.
    pub(crate) fn model(&self, i: usize) -> RobotModel {
        let mut model = self.nominal.clone();
        let hidden = &self.robots[i].hidden;
        // what is hidden replaces what the model lists
        model
            .effects
            .retain(|listed| hidden.iter().all(|effect| effect.effect != listed.effect));
        model.effects.extend(hidden.iter().cloned());
        model
    }

    /// The physics of robot `i`.
    ///
    /// # Errors
    /// As [`Physics::new`].
    pub(crate) fn physics(&self, i: usize) -> Result<Physics, String> {
        let mut physics = Physics::new(&self.model(i))?;
        physics.strange.extend(self.robots[i].strange);
        Ok(physics)
    }

    /// The name of robot `i`.
    pub(crate) fn name(i: usize) -> String {
        format!("r{}", i + 1)
    }
}
