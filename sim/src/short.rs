//! Short ways through the most common steps of a plain robot. They compute what the general step
//! computes, in fewer terms, and refuse where it would find something to decide.

use crate::command::CommandKind;
use crate::cruise::Cruise;
use crate::operator::Operator;
use crate::robot::Robot;
use crate::rows::Elements;
use crate::scalar::{Pair, Scalar};
use crate::skid::Skid;
use crate::state::{Body, Mode};

/// A short way.
#[derive(Debug, Clone)]
pub(crate) enum Short<S> {
    /// Both wheels roll.
    Rolling(Cruise<S>),
    /// Both wheels slide.
    Sliding(Skid<S>),
}

impl<S: Scalar> Short<S> {
    /// The way for `mode`, if there is one: nothing rubs, drags, pulls or pushes but the wheels'
    /// contacts, and torques reach the wheels as they are told.
    pub(crate) fn new(robot: &Robot<S>, mode: &Mode<S>, operator: &Operator<S>) -> Option<Self> {
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
            (Elements::WHEELS, grip) => Some(Self::Rolling(Cruise::new(robot, grip, operator))),
            (held, [Some(right), Some(left)]) if held.is_empty() => {
                Some(Self::Sliding(Skid::new([right, left], operator)))
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
