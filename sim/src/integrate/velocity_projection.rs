//! Velocity projection on an active set: the change of velocity by an inelastic impulse at its
//! constraints.

use super::state::State;
use crate::dynamics::inertia::{constrained_dynamics, inertia_matrix, wheel_inertias};
use crate::dynamics::prescribed::enforce_rolling;
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint};
use crate::parts::scalar::{Scalar, Vector};
use crate::robot::Robot;

/// The velocity without what the constraints in `active` forbid. Prescribed wheel speeds stay.
pub(super) fn project_velocity<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    active: ConstraintSet,
) -> Vector<S> {
    let (kind, gear) = (state.mode.kind, state.mode.gear);
    let dynamics = constrained_dynamics(robot, &state.mode.dynamics_key(active, 0.0));
    let inertia = inertia_matrix(robot, wheel_inertias(robot, gear));
    let mut nu = dynamics.project(&inertia, &state.body.nu);
    if kind == CommandKind::Speed {
        for (i, axle) in FrictionConstraint::AXLES.into_iter().enumerate() {
            nu += dynamics.response(axle.rows()[0], state.body.nu[3 + i]);
        }
    }
    enforce_rolling(robot, kind, active, &mut nu);
    nu
}
