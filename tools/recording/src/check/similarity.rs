//! Cosine similarity of two sources of the same quantity, and the factor between them.

/// Fewest windows in which both sources must have a value.
const MIN_WINDOWS: usize = 10;

/// How similar two sources are, over the windows in which both have a value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Similarity {
    /// Cosine similarity: 1 if equal up to a factor, -1 if opposite, 0 if unrelated.
    pub(super) cosine: f64,
    /// Factor from the second source to the first (least squares).
    pub(super) factor: f64,
}

/// Compares two sources. `None` if fewer than ten windows have both, or if one of them is zero.
pub(super) fn similarity(a: &[f64], b: &[f64]) -> Option<Similarity> {
    let (mut aa, mut ab, mut bb, mut windows) = (0.0, 0.0, 0.0, 0);
    for (a, b) in a.iter().zip(b) {
        if a.is_finite() && b.is_finite() {
            aa += a * a;
            ab += a * b;
            bb += b * b;
            windows += 1;
        }
    }
    if windows < MIN_WINDOWS || aa <= 0.0 || bb <= 0.0 {
        return None;
    }
    Some(Similarity {
        cosine: ab / (aa * bb).sqrt(),
        factor: ab / bb,
    })
}

/// The cosine of [`similarity`].
pub(super) fn cosine(a: &[f64], b: &[f64]) -> Option<f64> {
    similarity(a, b).map(|similarity| similarity.cosine)
}

/// Combines two lists item by item.
pub(super) fn combine(a: &[f64], b: &[f64], combine: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| combine(*a, *b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scaled_copy_has_cosine_one_and_its_factor() {
        let b: Vec<f64> = (0..20).map(|i| f64::from(i).sin()).collect();
        let a: Vec<f64> = b.iter().map(|b| -3.0 * b).collect();
        let found = similarity(&a, &b).unwrap();
        assert!((found.cosine + 1.0).abs() < 1e-12);
        assert!((found.factor + 3.0).abs() < 1e-12);
        assert!(similarity(&a[..9], &b).is_none());
    }
}
