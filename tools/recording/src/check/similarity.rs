//! How well two lists agree.

/// How two lists go together, over the windows in which both say something.
#[derive(Debug, Clone, Copy)]
pub(super) struct Agreement {
    /// Cosine between them: 1 the same up to a factor, -1 opposite, 0 unrelated.
    pub(super) cosine: f64,
    /// The factor from the second to the first (least squares).
    pub(super) factor: f64,
}

/// Compares two lists; `None` where fewer than ten windows have both, or one of them rests.
pub(super) fn agreement(a: &[f64], b: &[f64]) -> Option<Agreement> {
    let (mut aa, mut ab, mut bb, mut n) = (0.0, 0.0, 0.0, 0);
    for (a, b) in a.iter().zip(b) {
        if a.is_finite() && b.is_finite() {
            aa += a * a;
            ab += a * b;
            bb += b * b;
            n += 1;
        }
    }
    if n < 10 || aa <= 0.0 || bb <= 0.0 {
        return None;
    }
    Some(Agreement {
        cosine: ab / (aa * bb).sqrt(),
        factor: ab / bb,
    })
}

/// Sum or difference of two lists, item by item.
pub(super) fn combine(a: &[f64], b: &[f64], combine: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| combine(*a, *b)).collect()
}
