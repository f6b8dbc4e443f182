//! Fisher information with nuisance parameters: what the initial states of the windows can explain is
//! projected out, the rest gives the Cramér-Rao bound.

use nalgebra::{DMatrix, DVector};

/// Cramér-Rao bound: the smallest possible standard deviation of each parameter, all estimated together.
/// `columns` are the derivatives of the predictions, one list of windows for each parameter; infinite if
/// the information is singular.
pub(crate) fn cramer_rao(columns: &[Vec<DVector<f64>>]) -> Vec<f64> {
    let count = columns.len();
    let information: DMatrix<f64> = DMatrix::from_fn(count, count, |a, b| {
        columns[a]
            .iter()
            .zip(&columns[b])
            .map(|(one, other)| one.dot(other))
            .sum::<f64>()
    });
    let scale: Vec<f64> = (0..count)
        .map(|a| information[(a, a)].sqrt().max(1e-300))
        .collect();
    let scaled = DMatrix::from_fn(count, count, |a, b| {
        information[(a, b)] / (scale[a] * scale[b])
    });
    let inverse = scaled.try_inverse();
    (0..count)
        .map(|a| {
            inverse
                .as_ref()
                .map_or(f64::INFINITY, |i| i[(a, a)].max(0.0).sqrt() / scale[a])
        })
        .collect()
}

/// The nuisance parameters of one window: its initial state and the phases of the encoders.
pub(crate) struct Nuisance {
    /// Weight of each row.
    scale: DVector<f64>,
    /// Orthonormal basis of what they can explain.
    basis: DMatrix<f64>,
}

impl Nuisance {
    /// `columns`: the weighted derivatives of the predictions.
    pub(crate) fn new(scale: DVector<f64>, columns: impl Iterator<Item = DVector<f64>>) -> Self {
        let basis = orthonormal(columns, scale.len());
        Self { scale, basis }
    }

    /// The part of a residual, weighted, that the nuisance parameters cannot explain.
    pub(crate) fn project_out(&self, residual: DVector<f64>) -> DVector<f64> {
        let residual = residual.component_mul(&self.scale);
        &residual - &self.basis * (self.basis.transpose() * &residual)
    }
}

/// Gram-Schmidt orthonormalisation, repeated once against rounding errors; dependent columns are left
/// out.
fn orthonormal(columns: impl Iterator<Item = DVector<f64>>, rows: usize) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for column in columns {
        let mut remainder = column.clone();
        for _ in 0..2 {
            for known in &basis {
                remainder -= known * known.dot(&remainder);
            }
        }
        if remainder.norm() > 1e-6 * column.norm() {
            basis.push(remainder.normalize());
        }
    }
    DMatrix::from_fn(rows, basis.len(), |row, column| basis[column][row])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_initial_state_is_projected_out() {
        let columns = [
            DVector::from_vec(vec![1.0, 1.0, 0.0]),
            DVector::from_vec(vec![2.0, 2.0, 0.0]),
        ];
        let nuisance = Nuisance::new(DVector::from_element(3, 1.0), columns.into_iter());
        assert_eq!(nuisance.basis.ncols(), 1);
        let rest = nuisance.project_out(DVector::from_vec(vec![3.0, 3.0, 4.0]));
        assert!((rest.norm_squared() - 16.0).abs() < 1e-12);
    }

    #[test]
    fn correlated_parameters_have_the_cramer_rao_bound() {
        let column = |values: [f64; 2]| vec![DVector::from_vec(values.to_vec())];
        // Two parameters with correlation 0.6: larger by 1 / √(1 − 0.36) than each alone.
        let bound = cramer_rao(&[column([2.0, 0.0]), column([0.6, 0.8])]);
        assert!((bound[0] - 0.5 / 0.8).abs() < 1e-12);
        assert!((bound[1] - 1.0 / 0.8).abs() < 1e-12);
    }
}
