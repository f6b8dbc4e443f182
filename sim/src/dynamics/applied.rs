//! Applied forces: velocity-dependent inertial forces of Eq. 3, gravity on a slope, forces of
//! effects and motor torques. They do not depend on which contacts stick.

use crate::effects::{Motion, Wrench};
use crate::parts::scalar::{Pair, Scalar, Vector, heading};
use crate::robot::Robot;

/// Generalised applied force at velocity `nu` and `pose`, averaged over `span` = [start (s), length
/// (s)], with `torque` at the wheels (N m).
#[inline]
pub(crate) fn applied_forces<S: Scalar>(
    robot: &Robot<S>,
    nu: &Vector<S>,
    pose: [S; 3],
    span: Pair<f64>,
    torque: Pair<S>,
) -> Vector<S> {
    let (m, [sx, sy]) = (robot.mass, robot.first_moment);
    let (u, w, rate) = (nu[0], nu[1], nu[2]);
    // The φ̇² terms of Eq. 3 with m13 and m23, in the body frame
    let mut wrench = Wrench {
        along: (m * w + sx * rate) * rate,
        across: (sy * rate - m * u) * rate,
        moment: -(sx * u + sy * w) * rate,
    };
    if robot.slope_gravity.is_some() || robot.effects.has_force {
        add_external_forces(robot, nu, pose, span, &mut wrench);
    }
    Vector::from([
        wrench.along,
        wrench.across,
        wrench.moment,
        torque[0] * robot.travel[0],
        torque[1] * robot.travel[1],
    ])
}

/// Adds gravity on a slope and the forces of effects.
fn add_external_forces<S: Scalar>(
    robot: &Robot<S>,
    nu: &Vector<S>,
    pose: [S; 3],
    span: Pair<f64>,
    wrench: &mut Wrench<S>,
) {
    let [cos, sin] = heading(pose[2]);
    if let Some([x, y]) = robot.slope_gravity {
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let [sx, sy] = robot.first_moment;
        wrench.along += robot.mass * along;
        wrench.across += robot.mass * across;
        wrench.moment += sx * across - sy * along;
    }
    let motion = motion(nu, pose, [cos, sin], span);
    robot.effects.force(&motion, wrench);
}

/// The motion on which effects may depend; `heading` = cosine and sine of the heading.
pub(crate) fn motion<S: Scalar>(
    nu: &Vector<S>,
    pose: [S; 3],
    heading: Pair<S>,
    [t_s, over_s]: Pair<f64>,
) -> Motion<S> {
    Motion {
        t_s,
        over_s,
        heading,
        velocity: [nu[0], nu[1]],
        yaw_rate: nu[2],
        pose,
    }
}

/// Forces from outside, as the equations of motion take them.
pub(crate) fn outside_force<S: Scalar>(robot: &Robot<S>, force: Vector<S>) -> Vector<S> {
    let [right, left] = robot.travel;
    let one = S::constant(1.0);
    force.component_mul(&Vector::from([one, one, one, right, left]))
}
