//! The built-in laws: the paper's, and computed torque.

use slipstream_bus::InputError;
use slipstream_bus::experiment::{Control, Law};

use crate::computed_torque::{AccelerationCommand, computed_torque, limit_turn};
use crate::controller::{
    AgentContext, Controller, ControllerError, DesiredTwist, InnerInput, OuterInput,
};
use crate::geometry::{Dynamics, Geometry};
use crate::kanayama::desired_twist;
use crate::wheel_torques::WheelTorques;

/// The law that `control.law` names.
#[derive(Debug, Clone)]
pub enum BuiltIn {
    /// The paper's law.
    Paper(Paper),
    /// Computed torque.
    ComputedTorque(Box<ComputedTorque>),
}

/// The paper's law: Eq. 12, and PI speed loops (sections 3 and 4).
#[derive(Debug, Clone)]
pub struct Paper {
    gains: Control,
}

/// The paper's outer loop (Eq. 12), and computed torque with friction-limited forces in place of the speed loops.
#[derive(Debug, Clone)]
pub struct ComputedTorque {
    gains: Control,
    geometry: Geometry,
    dynamics: Dynamics,
    /// v_r (m/s) and w_r (rad/s) at the last outer tick.
    reference_velocity: [f64; 2],
    /// Their change since the tick before (m/s², rad/s²).
    reference_rate: [f64; 2],
}

impl BuiltIn {
    /// The law of a robot.
    ///
    /// # Errors
    /// The robot does not hear the one that it follows, or its model lacks what the law needs.
    pub fn new(context: &AgentContext<'_>) -> Result<Self, InputError> {
        let settings = context.settings();
        let ahead = context.robot().checked_sub(1);
        let lacks = ahead.filter(|ahead| !context.hears().contains(ahead));
        if let Some(ahead) = lacks.filter(|_| !settings.open_loop.enabled) {
            let ahead = slipstream_bus::message::robot_name(ahead);
            let name = context.name();
            let problem = format!(
                "has no link {ahead}>{name}: the built-in controller follows the robot ahead"
            );
            let remedy = format!("add the link, or give {name} a program of its own (--agent)");
            return Err(InputError::new("links.topology", problem, remedy));
        }
        Ok(match settings.control.law {
            Law::Paper => Self::Paper(Paper::new(context)),
            Law::ComputedTorque => Self::ComputedTorque(Box::new(ComputedTorque::new(context)?)),
        })
    }
}

impl Controller for BuiltIn {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        match self {
            Self::Paper(law) => law.outer(now),
            Self::ComputedTorque(law) => law.outer(now),
        }
    }

    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        match self {
            Self::Paper(law) => law.inner(now),
            Self::ComputedTorque(law) => law.inner(now),
        }
    }
}

impl Paper {
    /// The law of a robot.
    pub fn new(context: &AgentContext<'_>) -> Self {
        let gains = context.settings().control.clone();
        Self { gains }
    }
}

impl Controller for Paper {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        Ok(desired_twist(
            now.error,
            now.reference_velocity,
            &self.gains,
        ))
    }
}

impl ComputedTorque {
    /// The law of a robot.
    ///
    /// # Errors
    /// Its model lacks masses or lengths.
    pub fn new(context: &AgentContext<'_>) -> Result<Self, InputError> {
        let geometry = context.geometry()?;
        let lacks = || {
            let name = context.name();
            let problem = format!("needs masses and lengths that the model of {name} lacks");
            let remedy = "give them in its robot.toml, or set control.law = \"paper\"";
            InputError::new("control.law", problem, remedy)
        };
        Ok(Self {
            gains: context.settings().control.clone(),
            dynamics: geometry.dynamics.ok_or_else(lacks)?,
            geometry,
            reference_velocity: [0.0; 2],
            reference_rate: [0.0; 2],
        })
    }
}

impl Controller for ComputedTorque {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let (velocity, before) = (now.reference_velocity, self.reference_velocity);
        self.reference_rate = [0, 1].map(|i| (velocity[i] - before[i]) / now.period_s);
        self.reference_velocity = velocity;
        Ok(desired_twist(now.error, velocity, &self.gains))
    }

    /// Acceleration of the reference (feed-forward) and k_v times the velocity error (feedback).
    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        let mut desired = now.desired;
        if let Some(friction) = now.friction {
            desired = limit_turn(desired, friction, &self.dynamics, &self.geometry);
        }
        let rate = if now.brakes {
            [0.0; 2]
        } else {
            self.reference_rate
        };
        let command = AccelerationCommand {
            acceleration: [0, 1].map(|i| rate[i] + self.gains.k_v * (desired[i] - now.velocity[i])),
            twist: now.velocity,
            friction: now.friction,
            torque_max_nm: self.gains.torque_max_nm,
        };
        Ok(computed_torque(&command, &self.dynamics, &self.geometry))
    }
}
