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

/// Writes the numbers of an axis: as many digits as steps of a twentieth of it need.
pub(crate) fn label(axis: &Range<f64>) -> impl Fn(&f64) -> String + use<> {
    let step = (axis.end - axis.start) / 20.0;
    let digits = (-step.log10().floor()).max(0.0) as usize;
    move |value| {
        if digits > 4 {
            return format!("{value:.1e}");
        }
        let text = format!("{value:.digits$}");
        // Nobody reads a sign before nothing.
        let zero = text.chars().all(|letter| "-0.".contains(letter));
        text.trim_start_matches(if zero { "-" } else { "" })
            .to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_the_digits_of_their_axis() {
        let text = |axis: Range<f64>, value: f64| label(&axis)(&value);
        assert_eq!(text(-1.2..1.0, -1e-17), "0.0");
        assert_eq!(text(-1.2..1.0, -0.4), "-0.4");
        assert_eq!(text(0.0..0.3, 0.05), "0.05");
        assert_eq!(text(0.0..15.0, 14.0), "14.0");
        assert_eq!(text(0.0..150.0, 120.0), "120");
        assert_eq!(text(0.0..1e-5, 2e-6), "2.0e-6");
    }

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
