//! Velocity that effects add to the motion of the wheels.

use crate::dynamics::applied::motion;
use crate::parts::scalar::{Pair, Scalar, Vector, heading};
use crate::robot::Robot;
use crate::robot::body::{Body, Carried};

/// What effects add to the motion of `body` before its first step, at time 0; `None` without such effects.
pub(super) fn carried_at_rest<S: Scalar>(robot: &Robot<S>, body: &Body<S>) -> Option<Carried<S>> {
    robot.effects.has_carry.then(|| {
        let velocity = carried_velocity(robot, &body.nu, body.pose, [0.0; 2]);
        Carried {
            velocity: [velocity[0], velocity[1], velocity[2]],
            rate: [S::constant(0.0); 3],
        }
    })
}

/// Velocity that effects add to `nu`, the one that the wheels give. A turn is about the middle of the
/// axle: c, which lies ahead of it, moves across the body.
pub(super) fn carried_velocity<S: Scalar>(
    robot: &Robot<S>,
    nu: &Vector<S>,
    pose: [S; 3],
    span: Pair<f64>,
) -> Vector<S> {
    let zero = S::constant(0.0);
    let mut added = [zero; 2];
    let motion = motion(nu, pose, heading(pose[2]), span);
    robot.effects.carry(&motion, &mut added);
    let [speed, turn_rate] = added;
    Vector::from([speed, robot.com_to_axle * turn_rate, turn_rate, zero, zero])
}
