//! Friction Jacobian of slow slip: where friction would reverse the slip within an explicit step,
//! the step is linearly implicit in it.

use super::state::State;
use crate::dynamics::constrained::{ConstrainedDynamics, inverse};
use crate::dynamics::forces::{Forces, sliding_direction};
use crate::dynamics::inertia::{inertia_matrix, wheel_inertias};
use crate::parts::friction_constraints::{
    ConstraintSet, FrictionConstraint, LATERAL, LONGITUDINAL_LEFT, LONGITUDINAL_RIGHT,
};
use crate::parts::scalar::{Matrix, Scalar};
use crate::parts::tolerances::{EXPLICIT_MAX, ROSENBROCK, SLIP_DIRECTION_MIN};
use crate::robot::Robot;
use crate::robot::mode::Mode;

/// Friction that is stiff against the length of a step.
pub(super) struct StiffFriction<S> {
    /// −∂F/∂ν of the kinetic friction at the wheels concerned, from the turning of its direction.
    pub(super) jacobian: Matrix<S>,
    /// Number of bisections after which an explicit step would do.
    pub(super) bisections: u32,
}

/// The friction of sliding wheels for which a step of `over_s` is too long; `None` if it is short
/// enough for all.
pub(super) fn friction_jacobian<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    forces: &Forces<S>,
    over_s: f64,
) -> Option<StiffFriction<S>> {
    let mode = &state.mode;
    let mut jacobian: Option<Matrix<S>> = None;
    let mut excess: f64 = 1.0;
    if !mode.active.intersection(ConstraintSet::WHEELS).is_empty() {
        // a sticking wheel confines the other's slip to one direction, which cannot turn
        return None;
    }
    for (i, wheel) in FrictionConstraint::WHEELS.into_iter().enumerate() {
        let (true, Some(friction)) = (mode.slides(wheel), mode.wheel_friction[i]) else {
            continue;
        };
        let slip = robot.slip_velocity(wheel, &state.body.nu);
        let [along, across] = slip.map(|v| v.value());
        let square = (along * along + across * across).max(SLIP_DIRECTION_MIN * SLIP_DIRECTION_MIN);
        let limit = friction.friction_kinetic * forces.contact.normal_n[i];
        let change = limit.value() * state.dynamics.mobility[i] * over_s;
        if change * change <= EXPLICIT_MAX * EXPLICIT_MAX * square {
            continue;
        }
        excess = excess.max(change * change / (EXPLICIT_MAX * EXPLICIT_MAX * square));
        let row = robot.jacobian_row([LONGITUDINAL_RIGHT, LONGITUDINAL_LEFT][i]);
        let speed = square.sqrt();
        let [along, across] = sliding_direction(robot, mode, wheel, &state.body.nu);
        let normal = row * across - robot.jacobian_row(LATERAL) * along;
        let own = normal * normal.transpose() * (limit / speed);
        // the method needs no exact Jacobian: without derivatives it adds no noise to theirs
        let own = own.map(|entry| S::constant(entry.value()));
        *jacobian.get_or_insert_with(Matrix::zeros) += own;
    }
    let jacobian = jacobian?;
    // each bisection divides the squared excess by four
    let bisections = (0.5 * excess.log2()).ceil().max(1.0);
    Some(StiffFriction {
        jacobian,
        bisections: bisections as u32,
    })
}

/// The constrained dynamics of a step of `over_s` that is linearly implicit in friction.
pub(super) fn implicit_dynamics<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    jacobian: Matrix<S>,
    over_s: f64,
) -> ConstrainedDynamics<S> {
    let mut matrix = inertia_matrix(robot, wheel_inertias(robot, mode.gear));
    matrix += jacobian * S::constant(ROSENBROCK * over_s);
    ConstrainedDynamics::new(robot, inverse(&matrix), mode.active)
}
