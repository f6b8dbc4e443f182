//! Scalar type of the plant: `f64`, or dual numbers that carry first derivatives (forward-mode
//! automatic differentiation).

use nalgebra::{SMatrix, SVector};
use num_dual::DualNum;

/// A real number with or without derivatives: `f64` and the first-order types of `num_dual`.
///
/// Branches of the plant depend on [`Scalar::value`] alone, so that all scalar types take the same
/// path.
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

/// Number of generalised velocities ν: surge and sway of c, yaw rate, right and left wheel speed.
pub(crate) const VELOCITIES: usize = 5;

/// A vector over the generalised velocities.
pub(crate) type Vector<S> = SVector<S, VELOCITIES>;

/// A matrix over the generalised velocities.
pub(crate) type Matrix<S> = SMatrix<S, VELOCITIES, VELOCITIES>;

/// A pair of numbers, [right, left] or [along, across].
pub type Pair<S> = [S; 2];

/// Cosine and sine of an angle, with first derivatives.
///
/// Implemented here instead of by the platform's library to give the same bits on every machine,
/// and to be inlined. Argument reduction by π/2 in three parts (Cody and Waite, 1980), then Taylor
/// series on [−π/4, π/4]: within 2.5e-16 for angles up to 1e5 rad.
#[inline]
pub(crate) fn heading<S: Scalar>(angle: S) -> Pair<S> {
    let value = angle.value();
    let quarters = (value * std::f64::consts::FRAC_2_PI).round_ties_even();
    let x = value - quarters * HALF_PI[0] - quarters * HALF_PI[1] - quarters * HALF_PI[2];
    let z = x * x;
    let sin = x + x * z * polynomial(z, &SIN);
    let cos = 1.0 - 0.5 * z + z * z * polynomial(z, &COS);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates; an f64 of 10^18 rad has no digits after the point anyway"
    )]
    let [cos, sin] = match quarters as i64 & 3 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    };
    if S::NDERIV == 0 {
        return [S::constant(cos), S::constant(sin)];
    }
    let change = angle - S::constant(value);
    [change * -sin + cos, change * cos + sin]
}

/// π/2 in three parts, the first two of 33 bits: their products with a small integer are exact.
const HALF_PI: [f64; 3] = [
    1.570_796_326_734_125_6,
    6.077_100_506_303_966e-11,
    2.022_266_248_795_950_6e-21,
];

/// Coefficients of (sin x − x) / x³ in x².
const SIN: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

/// Coefficients of (cos x − 1 + x²/2) / x⁴ in x².
const COS: [f64; 8] = [
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 6_402_373_705_728_000.0,
];

/// A polynomial of eight coefficients by Estrin's scheme: independent terms, for instruction-level
/// parallelism.
#[inline]
fn polynomial(z: f64, c: &[f64; 8]) -> f64 {
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * z2;
    let high = (c[4] + c[5] * z) + (c[6] + c[7] * z) * z2;
    low + high * z4
}

/// The one with the larger value.
pub(crate) fn larger<S: Scalar>(a: S, b: S) -> S {
    if a.value() >= b.value() { a } else { b }
}

/// `value` limited to [`low`, `high`].
pub(crate) fn clamp<S: Scalar>(value: S, low: S, high: S) -> S {
    if value.value() < low.value() {
        low
    } else if value.value() > high.value() {
        high
    } else {
        value
    }
}

/// Squared Euclidean length of a pair, without derivatives.
#[inline]
pub(crate) fn length_square<S: Scalar>(pair: Pair<S>) -> f64 {
    let [a, b] = [pair[0].value(), pair[1].value()];
    a * a + b * b
}

/// Euclidean length of a pair. A zero pair has length zero and zero derivatives.
pub(crate) fn length<S: Scalar>(pair: Pair<S>) -> S {
    let square = pair[0] * pair[0] + pair[1] * pair[1];
    if square.value() == 0.0 {
        S::constant(0.0)
    } else {
        square.sqrt()
    }
}

/// The one with the smaller value.
pub(crate) fn smaller<S: Scalar>(a: S, b: S) -> S {
    if a.value() <= b.value() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::heading;

    #[test]
    fn agrees_with_the_standard_library() {
        for k in -200_000..200_000 {
            let angle = f64::from(k) * 0.377_13;
            let [cos, sin] = heading(angle);
            let (expected_sin, expected_cos) = angle.sin_cos();
            let tolerance = 2.5e-16;
            assert!(
                (cos - expected_cos).abs() <= tolerance,
                "cos {angle}: {cos} {expected_cos}"
            );
            assert!(
                (sin - expected_sin).abs() <= tolerance,
                "sin {angle}: {sin} {expected_sin}"
            );
        }
    }
}
