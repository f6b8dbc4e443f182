//! Active-set change: what sticks is decided anew, and velocities are projected on it.

use super::fast::FastPath;
use super::state::State;
use crate::contact::friction_solver::FrictionProblem;
use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::forces::{applied_forces, forces_at};
use crate::dynamics::inertia::{
    constrained_dynamics, inertia_matrix, is_damped, motor_damping, motor_torque, wheel_inertias,
};
use crate::dynamics::prescribed::{enforce_rolling, prescribed_acceleration};
use crate::integrate::events::friction_at;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::{ACROSS, Element, ElementSet};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::AT_REST_MAX;
use crate::robot::Robot;
use crate::robot::body::{DynamicsKey, can_slide};

/// What is known to have changed when the mode is decided anew.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ActiveSetChange {
    /// ElementSet that slid and came to rest.
    pub(super) stopped: ElementSet,
    /// ElementSet that stuck and broke away.
    pub(super) broken: ElementSet,
}

/// Acceleration in the mode as it is now.
pub(crate) fn acceleration_now<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    supply: &ActuatorOutput<S>,
) -> Vector<S> {
    prepare_dynamics(robot, state, span, supply);
    let (operator, nu) = (&state.operator, &state.body.nu);
    let [applied, forced] =
        applied_forces_now(robot, state, operator, &state.dynamics_key, span, supply);
    let balance = forces_at(robot, &state.mode, operator, nu, applied, forced[0]);
    operator.accelerate(&balance.force) + forced
}

/// Forces at this instant that do not depend on what sticks, and the acceleration that exact wheel
/// speeds force on the robot under `operator`.
fn applied_forces_now<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    operator: &ConstrainedDynamics<S>,
    dynamics_key: &DynamicsKey,
    span: Pair<f64>,
    supply: &ActuatorOutput<S>,
) -> [Vector<S>; 2] {
    let body = &state.body;
    let mut torque = motor_torque(robot, state.mode.kind, supply.mean);
    let loss = motor_damping(robot, state.mode.kind);
    for (i, torque) in torque.iter_mut().enumerate() {
        let engaged = state.mode.gear[i].is_engaged();
        *torque = if engaged {
            *torque - loss * body.nu[3 + i]
        } else {
            S::constant(0.0)
        };
    }
    let mut applied = applied_forces(robot, &body.nu, body.pose[2], span, torque);
    for i in 0..2 {
        applied[i] -= robot.damping[i] * body.nu[i];
    }
    let applied = state.load.map_or(applied, |load| applied + load);
    let forced = prescribed_acceleration(robot, operator, dynamics_key, span[1], supply);
    forced.map_or([applied, Vector::zeros()], |[forced, taken]| {
        [applied - taken, forced]
    })
}

/// Decides anew what sticks among all elements that stand, and takes from those that do what rounding has left of their motion.
pub(crate) fn update_active_set<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    supply: &ActuatorOutput<S>,
    change: ActiveSetChange,
) {
    state.redundant_force = None;
    let stands = |element: &Element| {
        let slides = state.mode.slides(*element);
        change.stopped.has(*element)
            || (!slides && sliding_speed(robot, state, *element) <= AT_REST_MAX)
    };
    let grip = friction_at(robot, state.body.pose);
    let loose = can_slide(robot, state.mode.kind, grip);
    let candidates = loose
        .iter()
        .filter(stands)
        .fold(ElementSet::default(), ElementSet::with);
    let rigid = ElementSet::WHEELS.without_all(loose);
    state.mode.grip = grip;
    state.mode.loose = loose;
    let (kind, gear) = (state.mode.kind, state.mode.gear);
    let key = DynamicsKey {
        held: rigid,
        gear,
        kind,
        over_s: 0.0,
    };
    let base = constrained_dynamics(robot, &key);
    let [applied, forced] = applied_forces_now(robot, state, &base, &key, span, supply);
    let standing = FrictionProblem {
        robot: robot,
        mode: &state.mode,
        mobility: base.acceleration.map(|entry| entry.value()),
        applied: applied.map(|f| f.value()),
        forced: forced.map(|a| a.value()),
        nu: state.body.nu.map(|v| v.value()),
        candidates,
        across: base.multiplier_vector(ACROSS).map(|entry| entry.value()),
    };
    let decision = standing.decide(change.broken);
    state.mode.held = rigid.either(decision.sticking);
    for element in candidates.iter() {
        state.mode.direction[element as usize] =
            decision.direction[element as usize].map(S::constant);
    }
    state.body.nu = project_velocity(robot, state, state.mode.held);
}

/// Speed at which an element slides, or would (m/s or rad/s).
pub(crate) fn sliding_speed<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    element: Element,
) -> f64 {
    let [along, across] = robot.seen(element, &state.body.nu).map(|v| v.value());
    along.hypot(across)
}

/// The velocities without what `held` elements forbid, as an impulse at them would leave them.
pub(crate) fn project_velocity<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    held: ElementSet,
) -> Vector<S> {
    let (kind, gear) = (state.mode.kind, state.mode.gear);
    let operator = constrained_dynamics(
        robot,
        &DynamicsKey {
            held,
            gear,
            kind,
            over_s: 0.0,
        },
    );
    let inertia = inertia_matrix(robot, wheel_inertias(robot, gear));
    let mut nu = operator.project(&inertia, &state.body.nu);
    if kind == CommandKind::Speed {
        for (i, axle) in Element::AXLES.into_iter().enumerate() {
            nu += operator.response(axle.rows()[0], state.body.nu[3 + i]);
        }
    }
    enforce_rolling(robot, kind, held, &mut nu);
    nu
}

/// Makes the operator for the mode and the length of this piece, unless it is there.
pub(crate) fn prepare_dynamics<S: Scalar>(
    robot: &Robot<S>,
    state: &mut State<S>,
    span: Pair<f64>,
    supply: &ActuatorOutput<S>,
) {
    if state.operator.redundant {
        let force = applied_forces_now(
            robot,
            state,
            &state.operator,
            &state.dynamics_key,
            span,
            supply,
        )[0]
        .map(|f| f.value());
        if state.redundant_force != Some(force) {
            update_active_set(robot, state, span, supply, ActiveSetChange::default());
            state.redundant_force = Some(force);
        }
    }
    let mode = &state.mode;
    let over_s = if is_damped(robot, mode.kind) {
        span[1]
    } else {
        0.0
    };
    let key = DynamicsKey {
        held: mode.held,
        gear: mode.gear,
        kind: mode.kind,
        over_s,
    };
    if key != state.dynamics_key {
        state.operator = constrained_dynamics(robot, &key);
        state.dynamics_key = key;
        state.short = FastPath::new(robot, &state.mode, &state.operator);
    }
}
