//! The equations of motion solved for one set of held elements: A = M⁻¹ projected on the motions
//! that the held rows leave free, and the multipliers that hold them.
//!
//! In the body frame every row of the contact Jacobian and the mass matrix of Eq. 3 are constants
//! of the robot, so that A changes only when an element starts or stops to slide.

use crate::robot::Robot;
use crate::rows::{Element, Elements, ROWS};
use crate::scalar::{Matrix, Scalar, VELOCITIES, Vector};

/// A row depends on earlier ones if what they leave of it is smaller than this share.
const DEPENDENT: f64 = 1e-9;

/// Accelerations and multipliers for a given force.
#[derive(Debug, Clone)]
pub(crate) struct Operator<S> {
    /// a = A F.
    pub(crate) acceleration: Matrix<S>,
    /// λ = Λ F for each held row, in the order of `held`.
    multipliers: [Vector<S>; VELOCITIES],
    /// The held rows, without those that depend on others.
    held: [usize; VELOCITIES],
    count: usize,
    /// Some held row beside the second wheel's [`crate::rows::ACROSS`] depends on others.
    pub(crate) redundant: bool,
}

impl<S: Scalar> Operator<S> {
    /// For the inertia `inverse`⁻¹ (damping included) and the held elements.
    pub(crate) fn new(robot: &Robot<S>, inverse: Matrix<S>, held: Elements) -> Self {
        let mut operator = Self {
            acceleration: inverse,
            multipliers: [Vector::from([S::constant(0.0); VELOCITIES]); VELOCITIES],
            held: [ROWS; VELOCITIES],
            count: 0,
            redundant: false,
        };
        for element in Element::ALL
            .into_iter()
            .filter(|&element| held.has(element))
        {
            for &row in element.rows() {
                if !operator.held.contains(&row) {
                    operator.hold(row, &robot.row(row), &inverse);
                }
            }
        }
        operator
    }

    /// Takes the row out of the motions that are free.
    fn hold(&mut self, row: usize, jacobian: &Vector<S>, inverse: &Matrix<S>) {
        let response = self.acceleration * jacobian;
        let pivot = jacobian.dot(&response);
        let alone = jacobian.dot(&(inverse * jacobian));
        if self.count == VELOCITIES || pivot.value() <= DEPENDENT * alone.value() {
            self.redundant = true;
            return;
        }
        let share = response * pivot.recip();
        self.acceleration -= response * share.transpose();
        let own = -share;
        for earlier in &mut self.multipliers[..self.count] {
            *earlier += own * earlier.dot(jacobian);
        }
        self.multipliers[self.count] = own;
        self.held[self.count] = row;
        self.count += 1;
        if self.count == VELOCITIES {
            // nothing can move, not even by rounding
            self.acceleration = Matrix::zeros();
        }
    }

    /// Multiplier of a row under `force`, zero where the row is free.
    pub(crate) fn multiplier(&self, row: usize, force: &Vector<S>) -> S {
        let held = self.held[..self.count].iter().position(|&held| held == row);
        held.map_or(S::constant(0.0), |at| self.multipliers[at].dot(force))
    }

    /// Multiplier of a row for each unit of each force, zero where the row is free.
    pub(crate) fn multiplier_vector(&self, row: usize) -> Vector<S> {
        let held = self.held[..self.count].iter().position(|&held| held == row);
        held.map_or_else(Vector::zeros, |at| self.multipliers[at])
    }

    /// Velocities (or accelerations) that follow where a held row is moved at `rate`.
    pub(crate) fn response(&self, row: usize, rate: S) -> Vector<S> {
        let held = self.held[..self.count].iter().position(|&held| held == row);
        held.map_or_else(Vector::zeros, |at| self.multipliers[at] * -rate)
    }

    /// Removes from `nu` what the held rows forbid, as an impulse at them would.
    pub(crate) fn project(&self, inertia: &Matrix<S>, nu: &Vector<S>) -> Vector<S> {
        self.acceleration * (inertia * nu)
    }
}

impl<S: Scalar> Robot<S> {
    /// The mass matrix of Eq. 3 over [surge, sway, yaw rate, wheel speeds] of c in the body frame,
    /// where m13 and m23 become constants. `wheels` is the inertia that turns with each wheel.
    pub(crate) fn inertia_matrix(&self, wheels: [S; 2]) -> Matrix<S> {
        let zero = S::constant(0.0);
        let (m, [sx, sy]) = (self.mass, self.moment);
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
            self.inertia,
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
}

/// Inverse of a symmetric positive matrix (Gauss and Jordan, without pivoting).
pub(crate) fn inverse<S: Scalar>(matrix: &Matrix<S>) -> Matrix<S> {
    let mut m = *matrix;
    for k in 0..VELOCITIES {
        let pivot = m[(k, k)].recip();
        m[(k, k)] = S::constant(1.0);
        for j in 0..VELOCITIES {
            m[(k, j)] *= pivot;
        }
        for i in (0..VELOCITIES).filter(|&i| i != k) {
            let factor = m[(i, k)];
            m[(i, k)] = S::constant(0.0);
            for j in 0..VELOCITIES {
                let change = factor * m[(k, j)];
                m[(i, j)] -= change;
            }
        }
    }
    m
}
