//! Applied forces at the present instant of a state, outside of a trial step.

use super::state::State;
use crate::dynamics::applied::{applied_forces, outside_force};
use crate::dynamics::constrained::ConstrainedDynamics;
use crate::dynamics::motors::{motor_damping, motor_torque};
use crate::dynamics::prescribed::prescribed_motion;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::robot::Robot;
use crate::robot::mode::DynamicsKey;

/// Forces and accelerations that do not depend on which constraints stick.
pub(super) struct Applied<S> {
    /// Generalised force, less what the prescribed acceleration takes of it.
    pub(super) force: Vector<S>,
    /// Acceleration that prescribed wheel speeds force on the robot.
    pub(super) prescribed: Vector<S>,
}

/// The applied forces now, with all damping explicit. `dynamics` belong to `key`.
pub(super) fn applied_now<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    dynamics: &ConstrainedDynamics<S>,
    key: &DynamicsKey,
    span: Pair<f64>,
    actuation: &ActuatorOutput<S>,
) -> Applied<S> {
    let body = &state.body;
    let mut torque = motor_torque(robot, state.mode.kind, actuation.mean);
    let damping = motor_damping(robot, state.mode.kind);
    for (i, torque) in torque.iter_mut().enumerate() {
        let engaged = state.mode.gear[i].is_engaged();
        *torque = if engaged {
            *torque - damping * body.nu[3 + i]
        } else {
            S::constant(0.0)
        };
    }
    let mut force = applied_forces(robot, &body.nu, body.pose, span, torque);
    for i in 0..2 {
        force[i] -= robot.damping[i] * body.nu[i];
    }
    let force = state
        .external_force
        .map_or(force, |outside| force + outside_force(robot, outside));
    match prescribed_motion(robot, dynamics, key, span[1], actuation) {
        None => Applied {
            force,
            prescribed: Vector::zeros(),
        },
        Some(motion) => Applied {
            force: force - motion.force,
            prescribed: motion.acceleration,
        },
    }
}
