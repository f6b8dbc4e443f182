//! Update of the active set: the contact solver decides which constraints at rest stick, and the
//! velocity is projected on those that do.

use super::floor::friction_at;
use super::instant::applied_now;
use super::state::State;
use super::velocity_projection::project_velocity;
use crate::contact::friction_solver::{ContactModes, FrictionProblem};
use crate::dynamics::inertia::constrained_dynamics;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint, LATERAL};
use crate::parts::scalar::{Pair, Scalar};
use crate::parts::tolerances::AT_REST_MAX;
use crate::robot::Robot;
use crate::robot::mode::frictional_constraints;

/// Changes that are known before the active set is updated.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ActiveSetChange {
    /// Constraints that slid and came to rest.
    pub(super) stopped: ConstraintSet,
    /// Constraints that stuck and broke away.
    pub(super) broken_away: ConstraintSet,
}

/// Updates the active set, given `change`, and the velocity with it: what rounding has left of the
/// slip of sticking constraints is removed.
pub(super) fn update_active_set<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
    change: ActiveSetChange,
) {
    state.redundant_force = None;
    let wheel_friction = friction_at(robot, state.body.pose);
    let frictional = frictional_constraints(robot, state.mode.kind, wheel_friction);
    // by the mode before the update
    let at_rest: ConstraintSet = frictional
        .iter()
        .filter(|&constraint| {
            change.stopped.contains(constraint)
                || (!state.mode.slides(constraint)
                    && slip_speed(robot, state, constraint) <= AT_REST_MAX)
        })
        .collect();
    let rigid = ConstraintSet::WHEELS.difference(frictional);
    state.mode.wheel_friction = wheel_friction;
    state.mode.frictional = frictional;
    let modes = solve_contact(robot, state, span, actuation, [rigid, at_rest], change);
    state.mode.active = rigid.union(modes.sticking);
    for constraint in at_rest.iter() {
        let i = constraint as usize;
        state.mode.direction[i] = modes.direction[i].map(S::constant);
    }
    state.body.nu = project_velocity(robot, state, state.mode.active);
}

/// Solves the friction problem of the constraints `at_rest`, with the wheels `rigid` that cannot
/// slide.
fn solve_contact<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
    [rigid, at_rest]: [ConstraintSet; 2],
    change: ActiveSetChange,
) -> ContactModes {
    let key = state.mode.dynamics_key(rigid, 0.0);
    let dynamics = constrained_dynamics(robot, &key);
    let applied = applied_now(robot, state, &dynamics, &key, span, actuation);
    let problem = FrictionProblem {
        robot,
        mode: &state.mode,
        mobility: dynamics.acceleration.map(|entry| entry.value()),
        applied: applied.force.map(|f| f.value()),
        prescribed: applied.prescribed.map(|a| a.value()),
        nu: state.body.nu.map(|v| v.value()),
        at_rest,
        lateral: dynamics
            .multiplier_vector(LATERAL)
            .map(|entry| entry.value()),
    };
    problem.solve(change.broken_away)
}

/// Slip speed of a constraint, whether it slides or sticks (m/s or rad/s).
pub(super) fn slip_speed<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    constraint: FrictionConstraint,
) -> f64 {
    let slip = robot.slip_velocity(constraint, &state.body.nu);
    let [along, across] = slip.map(|v| v.value());
    along.hypot(across)
}
