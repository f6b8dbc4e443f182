//! Choice of the fast path for a mode.

use super::rolling::RollingStep;
use super::sliding::SlidingStep;
use crate::dynamics::constrained::ConstrainedDynamics;
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::ConstraintSet;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;
use crate::robot::body::Body;
use crate::robot::mode::Mode;

/// A fast path through a step.
#[derive(Debug, Clone)]
pub(crate) enum FastPath<S> {
    /// Both wheels roll.
    Rolling(RollingStep<S>),
    /// Both wheels slide.
    Sliding(SlidingStep<S>),
}

impl<S: Scalar> FastPath<S> {
    /// The fast path for `mode`, if there is one: commands are torques that reach the wheels
    /// unchanged, and only the wheels' contacts act on the robot.
    pub(crate) fn new(
        robot: &Robot<S>,
        mode: &Mode<S>,
        dynamics: &ConstrainedDynamics<S>,
    ) -> Option<Self> {
        let plain = robot.dry_friction.constraints.is_empty()
            && robot.slope_gravity.is_none()
            && robot.load.transfer.is_none()
            && robot.actuator.gap_rad.is_none()
            && robot.actuator.passes_torque()
            && !(robot.damped || robot.has_slip_ratio)
            && !(robot.effects.has_force || robot.effects.has_floor || robot.effects.has_carry);
        if !plain || mode.kind != CommandKind::Torque {
            return None;
        }
        match (mode.active, mode.wheel_friction) {
            (ConstraintSet::WHEELS, friction) => {
                Some(Self::Rolling(RollingStep::new(robot, friction, dynamics)))
            }
            (active, [Some(right), Some(left)]) if active.is_empty() => {
                Some(Self::Sliding(SlidingStep::new([right, left], dynamics)))
            }
            _ => None,
        }
    }

    /// Advances `body` by `over_s` (s) under `torque` (N m) and forces from `outside`, or returns `false`
    /// without a change where the general step has to decide.
    #[inline]
    pub(crate) fn step(
        &self,
        robot: &Robot<S>,
        outside: Option<&Vector<S>>,
        body: &mut Body<S>,
        over_s: f64,
        torque: Pair<S>,
    ) -> bool {
        match self {
            Self::Rolling(rolling) => {
                outside.is_none() && rolling.step(robot, body, over_s, torque)
            }
            Self::Sliding(sliding) => sliding.step(robot, outside, body, over_s, torque),
        }
    }
}
