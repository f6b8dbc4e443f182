//! What an axis has to span.

use std::ops::Range;

/// All finite values with a margin of 3 %; 0 to 1 without any.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let empty = (f64::INFINITY, f64::NEG_INFINITY);
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold(empty, |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low > high {
        return 0.0..1.0;
    }
    // One value alone is shown with its own size around it, or with 1 around zero.
    let alone = if high == 0.0 { 1.0 } else { 0.1 * high.abs() };
    let margin = if low < high {
        0.03 * (high - low)
    } else {
        alone
    };
    low - margin..high + margin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_range_can_be_drawn() {
        for values in [
            vec![],
            vec![f64::NAN],
            vec![0.0],
            vec![-1e9],
            vec![1e-12, 2e-12],
        ] {
            let range = range(values.iter().copied());
            assert!(range.start < range.end, "{values:?}: {range:?}");
        }
    }
}
