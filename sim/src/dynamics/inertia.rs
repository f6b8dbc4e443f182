//! Mass matrix of Eq. 3 with implicit damping, and the torque of the motors.

use super::constrained::{ConstrainedDynamics, inverse};
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::Element;
use crate::parts::scalar::{Matrix, Pair, Scalar, Vector};
use crate::parts::tolerances::MOTOR_SHARE;
use crate::robot::Robot;
use crate::robot::body::{DynamicsKey, Gear};

/// The mass matrix of Eq. 3 over [surge, sway, yaw rate, wheel speeds] of c in the body frame,
/// where m13 and m23 become constants. `wheels` is the inertia that turns with each wheel.
pub(crate) fn inertia_matrix<S: Scalar>(robot: &Robot<S>, wheels: [S; 2]) -> Matrix<S> {
    let zero = S::constant(0.0);
    let (m, [sx, sy]) = (robot.mass, robot.moment);
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
        robot.inertia,
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

/// The operator for `key`. Damping enters implicitly, with the weight that keeps it stable:
/// half of the step where it is slow against the step, more where it is fast.
pub(crate) fn constrained_dynamics<S: Scalar>(
    robot: &Robot<S>,
    key: &DynamicsKey,
) -> ConstrainedDynamics<S> {
    let matrix = effective_inertia(robot, key.kind, key.gear, key.over_s);
    let rigid = key.kind == CommandKind::Speed;
    let axles = Element::AXLES.into_iter().zip(key.gear);
    let held = axles
        .filter(|(_, gear)| rigid && gear.is_engaged())
        .fold(key.held, |held, (axle, _)| held.with(axle));
    ConstrainedDynamics::new(robot, inverse(&matrix), held)
}

/// Inertia, and what damping adds to it over a step.
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
            let own = matrix[(i, i)];
            matrix[(i, i)] += damping[i] * implicit_span(damping[i] / own, over_s);
        }
    }
    matrix
}

/// What turns with each wheel: with play, the motor's share only while it is engaged.
pub(crate) fn wheel_inertias<S: Scalar>(robot: &Robot<S>, gear: [Gear; 2]) -> Pair<S> {
    gear.map(|gear| {
        let share = if gear.is_engaged() {
            1.0
        } else {
            1.0 - MOTOR_SHARE
        };
        robot.wheel_inertia * share
    })
}

/// Torque lost at each motor for each rad/s.
pub(crate) fn motor_damping<S: Scalar>(robot: &Robot<S>, kind: CommandKind) -> S {
    match kind {
        CommandKind::Voltage => robot.drive.droop + robot.drive.back_emf,
        CommandKind::Torque => robot.drive.droop,
        CommandKind::Speed => S::constant(0.0),
    }
}

/// Force lost for each unit of each velocity.
pub(crate) fn damping_vector<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    gear: [Gear; 2],
) -> Vector<S> {
    let mut damping = robot.damping;
    for (i, gear) in gear.into_iter().enumerate() {
        let engaged = gear.is_engaged();
        damping[3 + i] = if engaged {
            motor_damping(robot, kind)
        } else {
            S::constant(0.0)
        };
    }
    damping
}

/// Whether the operator depends on the length of the step.
pub(crate) fn is_damped<S: Scalar>(robot: &Robot<S>, kind: CommandKind) -> bool {
    robot.damped || kind == CommandKind::Voltage
}

/// Torque of each motor without what it loses with speed.
pub(crate) fn motor_torque<S: Scalar>(
    robot: &Robot<S>,
    kind: CommandKind,
    mean: Pair<S>,
) -> Pair<S> {
    match kind {
        CommandKind::Torque => mean,
        CommandKind::Voltage => {
            let per_volt = robot.drive.torque_per_volt.unwrap_or(S::constant(0.0));
            mean.map(|volts| volts * per_volt)
        }
        CommandKind::Speed => [S::constant(0.0); 2],
    }
}

/// Length of the implicit part of a step of `over_s` for a velocity damped at `rate` (1/s).
fn implicit_span<S: Scalar>(rate: S, over_s: f64) -> f64 {
    let z = rate.value() * over_s;
    let share = if z > 2.0 { 1.0 - 1.0 / z } else { 0.5 };
    share * over_s
}
