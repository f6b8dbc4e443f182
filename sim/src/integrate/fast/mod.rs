//! FastPath ways through the most common steps of a plain robot. They compute what the general step
//! computes, in fewer terms, and refuse where it would find something to decide.

mod rolling;
mod sliding;

use rolling::RollingStep;
use sliding::SlidingStep;

use crate::dynamics::constrained::ConstrainedDynamics;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::ElementSet;
use crate::parts::scalar::{Pair, Scalar};
use crate::robot::Robot;
use crate::robot::body::{Body, Mode};

/// A short way.
#[derive(Debug, Clone)]
pub(crate) enum FastPath<S> {
    /// Both wheels roll.
    Rolling(RollingStep<S>),
    /// Both wheels slide.
    Sliding(SlidingStep<S>),
}

impl<S: Scalar> FastPath<S> {
    /// The way for `mode`, if there is one: nothing rubs, drags, pulls or pushes but the wheels'
    /// contacts, and torques reach the wheels as they are told.
    pub(crate) fn new(
        robot: &Robot<S>,
        mode: &Mode<S>,
        operator: &ConstrainedDynamics<S>,
    ) -> Option<Self> {
        let plain = robot.dry.elements.is_empty()
            && robot.pull.is_none()
            && robot.load.transfer.is_none()
            && robot.drive.gap_rad.is_none()
            && robot.drive.is_direct()
            && !(robot.damped || robot.effects.has_force || robot.effects.has_floor);
        if !plain || mode.kind != CommandKind::Torque {
            return None;
        }
        match (mode.held, mode.grip) {
            (ElementSet::WHEELS, grip) => {
                Some(Self::Rolling(RollingStep::new(robot, grip, operator)))
            }
            (held, [Some(right), Some(left)]) if held.is_empty() => {
                Some(Self::Sliding(SlidingStep::new([right, left], operator)))
            }
            _ => None,
        }
    }

    /// One step, or `false` where the general step has to look.
    #[inline]
    pub(crate) fn step(
        &self,
        robot: &Robot<S>,
        body: &mut Body<S>,
        over_s: f64,
        torque: Pair<S>,
    ) -> bool {
        match self {
            Self::Rolling(cruise) => cruise.step(robot, body, over_s, torque),
            Self::Sliding(skid) => skid.step(robot, body, over_s, torque),
        }
    }
}
