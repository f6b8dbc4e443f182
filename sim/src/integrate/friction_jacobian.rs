//! Friction Jacobian of slow slip: where explicit steps are unstable, friction enters implicitly.

use super::state::State;
use crate::dynamics::constrained::{ConstrainedDynamics, inverse};
use crate::dynamics::forces::{Forces, sliding_direction};
use crate::dynamics::inertia::{inertia_matrix, wheel_inertias};
use crate::parts::friction_elements::{ACROSS, ALONG_LEFT, ALONG_RIGHT, Element, ElementSet};
use crate::parts::scalar::{Matrix, Scalar};
use crate::parts::tolerances::{EXPLICIT_MAX, ROSENBROCK, SLIP_DIRECTION_MIN};
use crate::robot::Robot;
use crate::robot::body::Mode;

/// Where the wheels' slip is so slow that friction would reverse it within the step: how friction
/// depends on it, and how often the step would have to be halved.
pub(crate) fn friction_jacobian<S: Scalar>(
    robot: &Robot<S>,
    state: &State<S>,
    balance: &Forces<S>,
    over_s: f64,
) -> Option<(Matrix<S>, u32)> {
    let mode = &state.mode;
    let mut brake: Option<Matrix<S>> = None;
    let mut excess: f64 = 1.0;
    if !mode.held.both(ElementSet::WHEELS).is_empty() {
        // one wheel holds the other's slip to a line
        return None;
    }
    for (i, wheel) in Element::WHEELS.into_iter().enumerate() {
        let (true, Some(grip)) = (mode.slides(wheel), mode.grip[i]) else {
            continue;
        };
        let [along, across] = robot.seen(wheel, &state.body.nu).map(|v| v.value());
        let square = (along * along + across * across).max(SLIP_DIRECTION_MIN * SLIP_DIRECTION_MIN);
        let limit = grip.friction_kinetic * balance.contact.normal_n[i];
        let change = limit.value() * state.operator.mobility[i] * over_s;
        if change * change <= EXPLICIT_MAX * EXPLICIT_MAX * square {
            continue;
        }
        excess = excess.max(change * change / (EXPLICIT_MAX * EXPLICIT_MAX * square));
        let row = robot.row([ALONG_RIGHT, ALONG_LEFT][i]);
        let speed = square.sqrt();
        let [along, across] = sliding_direction(robot, mode, wheel, &state.body.nu);
        let turn = row * across - robot.row(ACROSS) * along;
        let own = turn * turn.transpose() * (limit / speed);
        // any matrix near the true one serves; its own derivatives would only add noise
        let own = own.map(|entry| S::constant(entry.value()));
        *brake.get_or_insert_with(Matrix::zeros) += own;
    }
    let brake = brake?;
    // each halving takes a fourth of it
    let halvings = (0.5 * excess.log2()).ceil().max(1.0);
    Some((brake, halvings as u32))
}

/// The operator in which `brake` enters implicitly.
pub(crate) fn implicit_dynamics<S: Scalar>(
    robot: &Robot<S>,
    mode: &Mode<S>,
    brake: Matrix<S>,
    over_s: f64,
) -> ConstrainedDynamics<S> {
    let mut matrix = inertia_matrix(robot, wheel_inertias(robot, mode.gear));
    matrix += brake * S::constant(ROSENBROCK * over_s);
    ConstrainedDynamics::new(robot, inverse(&matrix), mode.held)
}
