//! Constrained dynamics in operator form: accelerations and Lagrange multipliers as linear
//! functions of the force, for one active set.
//!
//! M a = F + Jᵀ λ with J a = 0 for the active rows gives a = A F, where A is M⁻¹ projected on the
//! motions that these rows leave free, and λ = Λ F. In the body frame the mass matrix of Eq. 3 and
//! every row of the contact Jacobian are constants of the robot, so that A and Λ change only with
//! the active set, the gears, the kind of command and, with damping, the length of the step
//! ([`DynamicsKey`](crate::robot::mode::DynamicsKey)).

use crate::parts::friction_constraints::{
    ConstraintSet, JACOBIAN_ROWS, LONGITUDINAL_LEFT, LONGITUDINAL_RIGHT,
};
use crate::parts::scalar::{Matrix, Scalar, VELOCITIES, Vector};
use crate::parts::tolerances::DEPENDENT_ROW;
use crate::robot::Robot;

/// A and Λ for one active set.
#[derive(Debug, Clone)]
pub(crate) struct ConstrainedDynamics<S> {
    /// A: the acceleration is a = A F.
    pub(crate) acceleration: Matrix<S>,
    /// Λ: the multiplier of each row is λ = Λ F. Zero where the row is inactive or redundant.
    multipliers: [Vector<S>; JACOBIAN_ROWS],
    /// Rows that are active and independent of those before them.
    active_rows: [bool; JACOBIAN_ROWS],
    /// Number of such rows.
    count: usize,
    /// Longitudinal slip acceleration of each driven wheel's contact per newton there (1/kg).
    pub(crate) mobility: [f64; 2],
    /// Some active row depends on others, besides the lateral row that both wheels share: the
    /// multipliers are then not unique.
    pub(crate) redundant: bool,
}

impl<S: Scalar> ConstrainedDynamics<S> {
    /// For the inverse of the (effective) mass matrix and the active set.
    pub(crate) fn new(robot: &Robot<S>, inverse: Matrix<S>, active: ConstraintSet) -> Self {
        let mut dynamics = Self {
            acceleration: inverse,
            multipliers: [Vector::zeros(); JACOBIAN_ROWS],
            active_rows: [false; JACOBIAN_ROWS],
            count: 0,
            mobility: [0.0; 2],
            redundant: false,
        };
        for constraint in active.iter() {
            for &row in constraint.rows() {
                if !dynamics.active_rows[row] {
                    dynamics.activate(row, &robot.jacobian_row(row), &inverse);
                }
            }
        }
        dynamics.mobility = [LONGITUDINAL_RIGHT, LONGITUDINAL_LEFT].map(|row| {
            let row = robot.jacobian_row(row);
            row.dot(&(dynamics.acceleration * row)).value()
        });
        dynamics
    }

    /// Adds one row to the active rows: a rank-one update of A and Λ.
    fn activate(&mut self, row: usize, jacobian: &Vector<S>, inverse: &Matrix<S>) {
        let response = self.acceleration * jacobian;
        let pivot = jacobian.dot(&response);
        let alone = jacobian.dot(&(inverse * jacobian));
        if self.count == VELOCITIES || pivot.value() <= DEPENDENT_ROW * alone.value() {
            self.redundant = true;
            return;
        }
        let scaled = response * pivot.recip();
        self.acceleration -= response * scaled.transpose();
        let own = -scaled;
        for (earlier, _) in self
            .multipliers
            .iter_mut()
            .zip(self.active_rows)
            .filter(|(_, active)| *active)
        {
            *earlier += own * earlier.dot(jacobian);
        }
        self.multipliers[row] = own;
        self.active_rows[row] = true;
        self.count += 1;
        if self.count == VELOCITIES {
            // nothing can move, not even by rounding
            self.acceleration = Matrix::zeros();
        }
    }

    /// Acceleration a = A F.
    #[inline]
    pub(crate) fn accelerate(&self, force: &Vector<S>) -> Vector<S> {
        // A is symmetric: row i equals column i, which is contiguous in memory
        let row = |i: usize| dot(self.acceleration.column(i).as_slice(), force);
        Vector::from([row(0), row(1), row(2), row(3), row(4)])
    }

    /// Multiplier of a row under `force`; zero where the row is inactive or redundant.
    #[inline]
    pub(crate) fn multiplier(&self, row: usize, force: &Vector<S>) -> S {
        dot(self.multipliers[row].as_slice(), force)
    }

    /// The row of Λ: multiplier per unit of each force.
    pub(crate) fn multiplier_vector(&self, row: usize) -> Vector<S> {
        self.multipliers[row]
    }

    /// Velocities (or accelerations) of the robot when an active row is moved at `rate`.
    pub(crate) fn response(&self, row: usize, rate: S) -> Vector<S> {
        self.multipliers[row] * -rate
    }

    /// Velocity projection: removes from `nu` what the active rows forbid, as an impulse at them
    /// would. `inertia` is the mass matrix that A was made of.
    pub(crate) fn project(&self, inertia: &Matrix<S>, nu: &Vector<S>) -> Vector<S> {
        self.acceleration * (inertia * nu)
    }
}

/// Scalar product, summed in an order that leaves the partial sums independent.
#[inline(always)]
fn dot<S: Scalar>(a: &[S], b: &Vector<S>) -> S {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + a[4] * b[4]
}

/// Inverse of a symmetric positive definite matrix by Gauss-Jordan elimination without pivoting.
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
