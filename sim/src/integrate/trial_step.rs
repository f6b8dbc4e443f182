//! Trial step with a fixed active set: Heun's method (explicit trapezoidal rule) with viscous
//! damping linearly implicit; slow slip, which is stiff, by a two-stage Rosenbrock method.

use super::friction_jacobian::{friction_jacobian, implicit_dynamics};
use super::friction_margin::friction_margin;
use super::kinematics::{advance_configuration, predicted_pose};
use super::mode_check::check_mode;
use super::outcome::StepOutcome;
use super::state::State;
use crate::dynamics::applied::{applied_forces, outside_force};
use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::forces::{Forces, forces_at};
use crate::dynamics::inertia::{inertia_matrix, wheel_inertias};
use crate::dynamics::motors::{damping_vector, is_damped, motor_torque};
use crate::dynamics::prescribed::{PrescribedMotion, enforce_rolling, prescribed_motion};
use crate::parts::actuator::ActuatorOutput;
use crate::parts::friction_constraints::ConstraintSet;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;
use crate::robot::body::Body;

/// Result of a trial step.
pub(super) struct TrialStep<S> {
    /// The state at its end, or at its start if it was rejected there.
    pub(super) body: Body<S>,
    pub(super) outcome: StepOutcome<S>,
}

/// Steps over `span` in the present mode, without changing the state. Where friction would be
/// unstable in an explicit step, the step is implicit in it if `implicit`, else rejected.
pub(super) fn trial_step<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
    implicit: bool,
) -> TrialStep<S> {
    let (from, mode) = (&state.body, &state.mode);
    let over_s = span[1];
    let rejected = |outcome| TrialStep {
        body: *from,
        outcome,
    };
    let stage = SharedStage::new(robot, state, span, actuation);
    let first = stage.forces(&state.dynamics, &from.nu, from.pose);
    let margin = friction_margin(robot, mode, &state.dynamics, &first);
    let exceeded = margin.map_or(ConstraintSet::default(), |margin| margin.exceeded);
    if !exceeded.is_empty() {
        return rejected(StepOutcome::LimitExceeded(exceeded));
    }
    let stiff = friction_jacobian(robot, state, &first, over_s);
    if let Some(stiff) = stiff.as_ref().filter(|_| !implicit) {
        return rejected(StepOutcome::TooLong(stiff.bisections));
    }
    let implicit = stiff.map(|stiff| implicit_dynamics(robot, mode, stiff.jacobian, over_s));
    let dynamics = implicit.as_ref().unwrap_or(&state.dynamics);

    let start = dynamics.accelerate(&first.force) + stage.prescribed_acceleration;
    let guess = from.nu + start * S::constant(over_s);
    let second = stage.forces(
        dynamics,
        &guess,
        predicted_pose(robot, from, &guess, over_s),
    );
    let end = dynamics.accelerate(&second.force) + stage.prescribed_acceleration;

    let mut body = *from;
    body.nu = match &implicit {
        None => from.nu + (start + end) * S::constant(0.5 * over_s),
        Some(dynamics) => rosenbrock(robot, state, dynamics, [&start, &end], over_s),
    };
    enforce_rolling(robot, mode.kind, mode.active, &mut body.nu);
    body.acceleration = end;
    body.contact = second.contact;
    body.lagged = actuation.lagged;
    advance_configuration(robot, state, &mut body, span, actuation, stage.torque);
    let mut outcome = check_mode(robot, state, &body, &guess, [&first, &second]);
    if let StepOutcome::Event(event) = &mut outcome {
        event.before = start;
    }
    TrialStep { body, outcome }
}

/// What both stages of a step have in common.
struct SharedStage<'a, S> {
    robot: &'a Robot<S>,
    state: &'a State<S>,
    span: Pair<f64>,
    /// Torques of the motors, without what they lose with speed (N m).
    torque: Pair<S>,
    /// The part of them that reaches the wheels: nothing through an open gear (N m).
    wheel_torque: Pair<S>,
    /// Viscous damping force at the start: its change over the step is in the effective mass
    /// matrix.
    damping: Option<Vector<S>>,
    prescribed: Option<PrescribedMotion<S>>,
    /// Acceleration that prescribed wheel speeds force on the robot.
    prescribed_acceleration: Vector<S>,
}

impl<'a, S: Scalar> SharedStage<'a, S> {
    #[inline]
    fn new(
        robot: &'a Robot<S>,
        state: &'a State<S>,
        span: Pair<f64>,
        actuation: &ActuatorOutput<S>,
    ) -> Self {
        let mode = &state.mode;
        let torque = motor_torque(robot, mode.kind, actuation.mean);
        let mut wheel_torque = torque;
        for (torque, gear) in wheel_torque.iter_mut().zip(mode.gear) {
            if !gear.is_engaged() {
                *torque = S::constant(0.0);
            }
        }
        let (dynamics, key) = (&state.dynamics, &state.dynamics_key);
        let prescribed = prescribed_motion(robot, dynamics, key, span[1], actuation);
        let damping =
            is_damped(robot, mode.kind).then(|| damping_vector(robot, mode.kind, mode.gear));
        Self {
            robot,
            state,
            span,
            torque,
            wheel_torque,
            damping: damping.map(|damping| damping.component_mul(&state.body.nu)),
            prescribed,
            prescribed_acceleration: prescribed
                .map_or(Vector::zeros(), |motion| motion.acceleration),
        }
    }

    /// Forces at velocity `nu` and `pose`.
    #[inline]
    fn forces(&self, dynamics: &ConstrainedDynamics<S>, nu: &Vector<S>, pose: [S; 3]) -> Forces<S> {
        let (robot, state) = (self.robot, self.state);
        let force = applied_forces(robot, nu, pose, self.span, self.wheel_torque);
        let force = self.damping.map_or(force, |damping| force - damping);
        let force = self.prescribed.map_or(force, |motion| force - motion.force);
        let force = state
            .external_force
            .map_or(force, |outside| force + outside_force(robot, outside));
        let surge = self.prescribed_acceleration[0];
        forces_at(robot, &state.mode, dynamics, nu, force, surge)
    }
}

/// Velocity at the end of a step of the two-stage Rosenbrock method, which is of second order with
/// any approximate Jacobian. `dynamics` are linearly implicit in friction; [`start`, `end`] are
/// their accelerations in the two stages.
fn rosenbrock<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    dynamics: &ConstrainedDynamics<S>,
    [start, end]: [&Vector<S>; 2],
    over_s: f64,
) -> Vector<S> {
    let inertia = inertia_matrix(robot, wheel_inertias(robot, state.mode.gear));
    let correction = dynamics.accelerate(&(inertia * start));
    let second = (end - correction * S::constant(2.0)) * S::constant(0.5);
    state.body.nu + (start * S::constant(1.5) + second) * S::constant(over_s)
}
