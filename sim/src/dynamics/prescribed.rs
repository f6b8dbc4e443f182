//! Motion that constraints prescribe: wheel speeds that follow a lag exactly, and rolling wheels.

use super::constrained::ConstrainedDynamics;
use super::inertia::effective_inertia;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint};
use crate::parts::scalar::{Scalar, Vector};
use crate::robot::Robot;
use crate::robot::mode::DynamicsKey;

/// The part of the motion that prescribed wheel speeds determine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PrescribedMotion<S> {
    /// Acceleration f that the changing wheel speeds force on the robot.
    pub(crate) acceleration: Vector<S>,
    /// M f.
    pub(crate) force: Vector<S>,
}

/// Acceleration f of wheel speeds that a lag changes over `over_s`; `None` without such.
///
/// With a = a' + f, M a = F + Jᵀ λ becomes M a' = (F − M f) + Jᵀ λ, where a' is zero in all active
/// rows: the multipliers of F − M f are those of the whole motion. M f is itself a combination of
/// active rows, so that it causes no motion a'. `dynamics` belong to `key`.
pub(crate) fn prescribed_motion<S: Scalar>(
    robot: &Robot<S>,
    dynamics: &ConstrainedDynamics<S>,
    key: &DynamicsKey,
    over_s: f64,
    actuation: &ActuatorOutput<S>,
) -> Option<PrescribedMotion<S>> {
    let DynamicsKey { kind, gear, .. } = *key;
    if kind != CommandKind::Speed || robot.actuator.lag_s.is_none() || over_s <= 0.0 {
        return None;
    }
    let mut acceleration = Vector::zeros();
    for (i, axle) in FrictionConstraint::AXLES.into_iter().enumerate() {
        let rate = (actuation.end[i] - actuation.start[i]) / over_s;
        acceleration += dynamics.response(axle.rows()[0], rate);
    }
    Some(PrescribedMotion {
        acceleration,
        force: effective_inertia(robot, kind, gear, key.over_s) * acceleration,
    })
}

/// Sets the velocities that rolling wheels determine from the others, so that Eq. 1 holds to the
/// last digit.
pub(crate) fn enforce_rolling<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    active: ConstraintSet,
    nu: &mut Vector<S>,
) {
    let rolls = FrictionConstraint::WHEELS.map(|wheel| active.contains(wheel));
    if rolls[0] || rolls[1] {
        nu[1] = robot.com_to_axle * nu[2];
    }
    if kind == CommandKind::Speed {
        return;
    }
    let turn = robot.half_track * nu[2];
    let ground = [nu[0] + turn, nu[0] - turn];
    for i in 0..2 {
        if rolls[i] && !active.contains(FrictionConstraint::AXLES[i]) {
            nu[3 + i] = ground[i] / robot.radius[i];
        }
    }
}
