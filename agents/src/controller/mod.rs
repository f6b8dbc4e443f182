//! Controller: the law of one robot, as the runtime calls it.

mod context;
mod input;

use serde::{Deserialize, Serialize};
use slipstream_bus::InputError;
use slipstream_bus::message::Extra;

pub use self::context::AgentContext;
pub use self::input::{Heard, InnerInput, OuterInput};
use crate::wheel_torques::WheelTorques;

/// Control law of one robot.
///
/// It has no I/O, clock or threads: the same inputs give the same outputs, so that runs repeat bit for bit. What
/// surrounds it (odometry, reference, links, watchdog, torque limit) is the runtime's.
///
/// ```
/// use slipstream_agents::{Controller, ControllerError, DesiredTwist, OuterInput};
///
/// /// Drives straight at a speed.
/// struct Straight {
///     speed_m_s: f64,
/// }
///
/// impl Controller for Straight {
///     fn outer(&mut self, _: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
///         Ok(DesiredTwist { v: self.speed_m_s, w: 0.0 })
///     }
/// }
/// ```
pub trait Controller: Send {
    /// One tick of the outer loop (20 Hz unless the experiment says otherwise): the desired velocities.
    ///
    /// # Errors
    /// The law cannot go on. The run ends with the text of the error.
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError>;

    /// One tick of the inner loop (50 Hz unless the experiment says otherwise): the torques of both wheels. Without an
    /// implementation of its own: the paper's PI speed loops within the torque limit that the experiment asks for.
    ///
    /// # Errors
    /// As [`Self::outer`].
    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        Ok(now.paper())
    }

    /// Numbers that the robot sends to those that hear it, beside pose and reference velocity. Asked for after each outer
    /// tick.
    fn message(&self) -> Extra {
        Extra::default()
    }
}

impl<C: Controller + ?Sized> Controller for Box<C> {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        (**self).outer(now)
    }

    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        (**self).inner(now)
    }

    fn message(&self) -> Extra {
        (**self).message()
    }
}

/// Desired velocities of the midpoint of the axle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DesiredTwist {
    /// v_d: forward velocity (m/s).
    pub v: f64,
    /// w_d: yaw rate (rad/s).
    pub w: f64,
}

/// Why a controller cannot be made or cannot go on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
pub enum ControllerError {
    /// A key of the experiment or of the robot's model.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Anything else, in words.
    #[error("{0}")]
    Failed(String),
}

impl From<&str> for ControllerError {
    fn from(reason: &str) -> Self {
        Self::Failed(reason.to_owned())
    }
}

impl From<String> for ControllerError {
    fn from(reason: String) -> Self {
        Self::Failed(reason)
    }
}
