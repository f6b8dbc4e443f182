//! Mass matrix of Eq. 3 in the body frame, and its effective form with linearly implicit damping.

use super::constrained::{ConstrainedDynamics, inverse};
use super::motors::{MOTOR_SHARE, damping_vector};
use crate::parts::command::CommandKind;
use crate::parts::friction_constraints::FrictionConstraint;
use crate::parts::scalar::{Matrix, Pair, Scalar};
use crate::robot::Robot;
use crate::robot::mode::{DynamicsKey, Gear};

/// The mass matrix of Eq. 3 over [surge, sway, yaw rate, wheel speeds] of c in the body frame,
/// where m13 and m23 become constants. `wheels` is the inertia that turns with each wheel (kg m²).
pub(crate) fn inertia_matrix<S: Scalar>(robot: &Robot<S>, wheels: [S; 2]) -> Matrix<S> {
    let zero = S::constant(0.0);
    let (m, [sx, sy]) = (robot.mass, robot.first_moment);
    Matrix::from_row_slice(&[
        m,
        zero,
        -sy,
        zero,
        zero, //
        zero,
        m,
        sx,
        zero,
        zero, //
        -sy,
        sx,
        robot.yaw_inertia,
        zero,
        zero, //
        zero,
        zero,
        zero,
        wheels[0],
        zero, //
        zero,
        zero,
        zero,
        zero,
        wheels[1],
    ])
}

/// The constrained dynamics for `key`, with damping treated implicitly.
pub(crate) fn constrained_dynamics<S: Scalar>(
    robot: &Robot<S>,
    key: &DynamicsKey,
) -> ConstrainedDynamics<S> {
    let matrix = effective_inertia(robot, key.kind, key.gear, key.over_s);
    let prescribed = key.kind == CommandKind::Speed;
    let axles = FrictionConstraint::AXLES.into_iter().zip(key.gear);
    let active = axles
        .filter(|(_, gear)| prescribed && gear.is_engaged())
        .fold(key.active, |active, (axle, _)| active.with(axle));
    ConstrainedDynamics::new(robot, inverse(&matrix), active)
}

/// Mass matrix plus the damping matrix times the length of the implicit part of a step of `over_s`.
pub(crate) fn effective_inertia<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    gear: [Gear; 2],
    over_s: f64,
) -> Matrix<S> {
    let mut matrix = inertia_matrix(robot, wheel_inertias(robot, gear));
    if over_s > 0.0 {
        let damping = damping_vector(robot, kind, gear);
        for i in 0..damping.len() {
            let inertia = matrix[(i, i)];
            matrix[(i, i)] += damping[i] * implicit_span(damping[i] / inertia, over_s);
        }
    }
    matrix
}

/// Inertia that turns with each wheel, times 1 - s of the wheel (kg m²): with backlash, the motor's share
/// only while the gear is engaged.
pub(crate) fn wheel_inertias<S: Scalar>(robot: &Robot<S>, gear: [Gear; 2]) -> Pair<S> {
    [0, 1].map(|i| {
        let share = if gear[i].is_engaged() {
            1.0
        } else {
            1.0 - MOTOR_SHARE
        };
        robot.wheel_inertia * share * robot.travel[i]
    })
}

/// Length (s) of the implicit part of a step of `over_s` for a velocity damped at `rate` (1/s):
/// half of the step (trapezoidal rule) where damping is slow against the step, more where it is
/// fast, to stay stable.
fn implicit_span<S: Scalar>(rate: S, over_s: f64) -> f64 {
    let z = rate.value() * over_s;
    let share = if z > 2.0 { 1.0 - 1.0 / z } else { 0.5 };
    share * over_s
}
