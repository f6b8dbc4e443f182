//! The Cholesky factor of a matrix that may be singular by rounding.

use nalgebra::{Cholesky, DMatrix, Dyn};

/// The factor of a matrix that is positive definite but for rounding: its diagonal is raised until it
/// is.
pub(crate) fn raised(matrix: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    [0.0, 1e-9, 1e-7, 1e-5, 1e-3].into_iter().find_map(|share| {
        let mut raised = matrix.clone();
        for i in 0..raised.nrows() {
            raised[(i, i)] += share * raised[(i, i)].abs();
        }
        raised.cholesky()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singular_matrix_is_raised_and_an_indefinite_one_is_not() {
        let of = |own: [f64; 4]| raised(&DMatrix::from_row_slice(2, 2, &own));
        let factor = of([1.0, 1.0, 1.0, 1.0]).map(|own| own.l());
        assert!(factor.is_some_and(|l| (l[(0, 0)] - 1.0).abs() < 1e-2 && l[(1, 1)] > 0.0));
        assert!(of([4.0, 2.0, 2.0, 3.0]).is_some_and(|own| own.l()[(0, 0)] == 2.0));
        assert!(of([1.0, 2.0, 2.0, 1.0]).is_none());
    }
}
