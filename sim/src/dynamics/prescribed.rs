//! Motion that constraints prescribe: exact wheel speeds that change, and wheels that roll.

use super::constrained::ConstrainedDynamics;
use super::inertia::effective_inertia;
use crate::parts::actuator::ActuatorOutput;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::{Element, ElementSet};
use crate::parts::scalar::{Scalar, Vector};
use crate::robot::Robot;
use crate::robot::body::DynamicsKey;

/// Acceleration f that exact wheel speeds force on the robot while their lag changes them, and M f.
///
/// With a = a' + f, M a = F + Jᵀ λ says M a' = (F − M f) + Jᵀ λ, where a' is zero in all held rows:
/// the multipliers of F − M f are those of the whole motion. M f, which multipliers alone give,
/// moves nothing itself. `dynamics_key` is what `operator` was made for.
pub(crate) fn prescribed_acceleration<S: Scalar>(
    robot: &Robot<S>,
    operator: &ConstrainedDynamics<S>,
    dynamics_key: &DynamicsKey,
    over_s: f64,
    supply: &ActuatorOutput<S>,
) -> Option<[Vector<S>; 2]> {
    let DynamicsKey { kind, gear, .. } = *dynamics_key;
    if kind != CommandKind::Speed || robot.drive.lag_s.is_none() || over_s <= 0.0 {
        return None;
    }
    let mut forced = Vector::zeros();
    for (i, axle) in Element::AXLES.into_iter().enumerate() {
        let rate = (supply.end[i] - supply.start[i]) / over_s;
        forced += operator.response(axle.rows()[0], rate);
    }
    Some([
        forced,
        effective_inertia(robot, kind, gear, dynamics_key.over_s) * forced,
    ])
}

/// Sets what a rolling wheel leaves no choice, so that Eq. 1 holds to the last digit.
pub(crate) fn enforce_rolling<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    set: ElementSet,
    nu: &mut Vector<S>,
) {
    let held = Element::WHEELS.map(|wheel| set.has(wheel));
    if held[0] || held[1] {
        nu[1] = robot.com_to_axle * nu[2];
    }
    if kind == CommandKind::Speed {
        return;
    }
    let turn = robot.half_track * nu[2];
    let ground = [nu[0] + turn, nu[0] - turn];
    for i in 0..2 {
        if held[i] && !set.has(Element::AXLES[i]) {
            nu[3 + i] = ground[i] / robot.radius[i];
        }
    }
}
