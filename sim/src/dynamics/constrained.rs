//! The equations of motion solved for one set of held elements: A = M⁻¹ projected on the motions
//! that the held rows leave free, and the multipliers that hold them.
//!
//! In the body frame every row of the contact Jacobian and the mass matrix of Eq. 3 are constants
//! of the robot, so that A changes only when an element starts or stops to slide.

use crate::parts::friction_elements::{ALONG_LEFT, ALONG_RIGHT, Element, ElementSet, ROWS};
use crate::parts::scalar::{Matrix, Scalar, VELOCITIES, Vector};
use crate::robot::Robot;

/// A row depends on earlier ones if what they leave of it is smaller than this share.
const DEPENDENT: f64 = 1e-9;

/// Accelerations and multipliers for a given force.
#[derive(Debug, Clone)]
pub(crate) struct ConstrainedDynamics<S> {
    /// a = A F.
    pub(crate) acceleration: Matrix<S>,
    /// λ = Λ F for each row, zero where it is free or depends on rows held before it.
    multipliers: [Vector<S>; ROWS],
    /// Rows held, without those that depend on others.
    held: [bool; ROWS],
    count: usize,
    /// ActiveSetChange of each contact's slip along its wheel for a newton there, 1/kg.
    pub(crate) mobility: [f64; 2],
    /// Some held row beside the second wheel's [`crate::parts::friction_elements::ACROSS`] depends on others.
    pub(crate) redundant: bool,
}

impl<S: Scalar> ConstrainedDynamics<S> {
    /// For the inertia `inverse`⁻¹ (damping included) and the held elements.
    pub(crate) fn new(robot: &Robot<S>, inverse: Matrix<S>, held: ElementSet) -> Self {
        let mut operator = Self {
            acceleration: inverse,
            multipliers: [Vector::zeros(); ROWS],
            held: [false; ROWS],
            count: 0,
            mobility: [0.0; 2],
            redundant: false,
        };
        for element in Element::ALL
            .into_iter()
            .filter(|&element| held.has(element))
        {
            for &row in element.rows() {
                if !operator.held[row] {
                    operator.hold(row, &robot.row(row), &inverse);
                }
            }
        }
        operator.mobility = [ALONG_RIGHT, ALONG_LEFT].map(|row| {
            let row = robot.row(row);
            row.dot(&(operator.acceleration * row)).value()
        });
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
        for (earlier, _) in self
            .multipliers
            .iter_mut()
            .zip(self.held)
            .filter(|(_, held)| *held)
        {
            *earlier += own * earlier.dot(jacobian);
        }
        self.multipliers[row] = own;
        self.held[row] = true;
        self.count += 1;
        if self.count == VELOCITIES {
            // nothing can move, not even by rounding
            self.acceleration = Matrix::zeros();
        }
    }

    /// Accelerations under `force`.
    #[inline]
    pub(crate) fn accelerate(&self, force: &Vector<S>) -> Vector<S> {
        // symmetric: row i is column i, which lies together
        let row = |i: usize| dot(self.acceleration.column(i).as_slice(), force);
        Vector::from([row(0), row(1), row(2), row(3), row(4)])
    }

    /// Multiplier of a row under `force`, zero where the row is free.
    #[inline]
    pub(crate) fn multiplier(&self, row: usize, force: &Vector<S>) -> S {
        dot(self.multipliers[row].as_slice(), force)
    }

    /// Multiplier of a row for each unit of each force, zero where the row is free.
    pub(crate) fn multiplier_vector(&self, row: usize) -> Vector<S> {
        self.multipliers[row]
    }

    /// Velocities (or accelerations) that follow where a held row is moved at `rate`.
    pub(crate) fn response(&self, row: usize, rate: S) -> Vector<S> {
        self.multipliers[row] * -rate
    }

    /// Removes from `nu` what the held rows forbid, as an impulse at them would.
    pub(crate) fn project(&self, inertia: &Matrix<S>, nu: &Vector<S>) -> Vector<S> {
        self.acceleration * (inertia * nu)
    }
}

/// Scalar product in an order that leaves the sums independent of each other.
#[inline(always)]
fn dot<S: Scalar>(a: &[S], b: &Vector<S>) -> S {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + a[4] * b[4]
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
