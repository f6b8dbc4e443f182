//! The numbers that the plant computes with: `f64`, or dual numbers that carry derivatives.

use nalgebra::{SMatrix, SVector};
use num_dual::DualNum;

/// A real number, with or without derivatives. Branches are decided by [`Scalar::value`] alone.
pub trait Scalar: DualNum<Primitive = f64> + Copy + nalgebra::Scalar {
    /// The number without its derivatives.
    fn value(&self) -> f64;

    /// A constant: a number whose derivatives are zero.
    fn constant(value: f64) -> Self {
        Self::from(value)
    }
}

impl<T: DualNum<Primitive = f64> + Copy + nalgebra::Scalar> Scalar for T {
    #[inline]
    fn value(&self) -> f64 {
        self.re()
    }
}

/// Number of velocities: surge and sway of c, yaw rate, speeds of the right and the left wheel.
pub const VELOCITIES: usize = 5;

/// A vector over the velocities.
pub type Vector<S> = SVector<S, VELOCITIES>;

/// A matrix over the velocities.
pub type Matrix<S> = SMatrix<S, VELOCITIES, VELOCITIES>;

/// A pair of numbers, [right, left] or [along, across].
pub type Pair<S> = [S; 2];

/// The number of larger value.
pub(crate) fn larger<S: Scalar>(a: S, b: S) -> S {
    if a.value() >= b.value() { a } else { b }
}

/// `value` moved into [`low`, `high`].
pub(crate) fn clamp<S: Scalar>(value: S, low: S, high: S) -> S {
    if value.value() < low.value() {
        low
    } else if value.value() > high.value() {
        high
    } else {
        value
    }
}

/// Length of a pair. Zero has the length zero and no derivative.
pub(crate) fn length<S: Scalar>(pair: Pair<S>) -> S {
    let square = pair[0] * pair[0] + pair[1] * pair[1];
    if square.value() == 0.0 {
        S::constant(0.0)
    } else {
        square.sqrt()
    }
}

/// The number of smaller value.
pub(crate) fn smaller<S: Scalar>(a: S, b: S) -> S {
    if a.value() <= b.value() { a } else { b }
}
