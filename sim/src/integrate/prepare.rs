//! Preparation of a step: the constrained dynamics for the present mode, and a unique solution
//! where the active set is redundant.

use super::active_set::{ActiveSetChange, update_active_set};
use super::fast::FastPath;
use super::instant::applied_now;
use super::state::State;
use crate::dynamics::forces::forces_at;
use crate::dynamics::inertia::constrained_dynamics;
use crate::dynamics::motors::is_damped;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;

/// Computes the constrained dynamics for the present mode and the length of `span`, unless the
/// state already has them.
///
/// A redundant active set has no unique multipliers, so that friction margins cannot tell when it
/// breaks away: the contact solver decides again whenever the applied force has changed.
pub(super) fn prepare_dynamics<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
) {
    if state.dynamics.redundant {
        let (dynamics, key) = (&state.dynamics, &state.dynamics_key);
        let applied = applied_now(robot, state, dynamics, key, span, actuation);
        let force = applied.force.map(|f| f.value());
        if state.redundant_force != Some(force) {
            update_active_set(robot, state, span, actuation, ActiveSetChange::default());
            state.redundant_force = Some(force);
        }
    }
    let mode = &state.mode;
    let damped = is_damped(robot, mode.kind);
    let key = mode.dynamics_key(mode.active, if damped { span[1] } else { 0.0 });
    if key != state.dynamics_key {
        state.dynamics = constrained_dynamics(robot, &key);
        state.dynamics_key = key;
        state.fast_path = FastPath::new(robot, &state.mode, &state.dynamics);
    }
}

/// Acceleration of the state in its present mode.
pub(super) fn acceleration_now<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
) -> Vector<S> {
    prepare_dynamics(robot, state, span, actuation);
    let (dynamics, key, nu) = (&state.dynamics, &state.dynamics_key, &state.body.nu);
    let applied = applied_now(robot, state, dynamics, key, span, actuation);
    let surge = applied.prescribed[0];
    let forces = forces_at(robot, &state.mode, dynamics, nu, applied.force, surge);
    dynamics.accelerate(&forces.force) + applied.prescribed
}
