//! Axis limits and tick labels.

use std::ops::Range;

/// The range of all finite values with a margin of 3 % on each side; 0 to 1 if there are none.
pub(crate) fn limits(values: impl Iterator<Item = f64>) -> Range<f64> {
    let empty = (f64::INFINITY, f64::NEG_INFINITY);
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold(empty, |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low > high {
        return 0.0..1.0;
    }
    // A single value gets a margin of a tenth of its size; zero gets a margin of 1.
    let margin_of_one = if high == 0.0 { 1.0 } else { 0.1 * high.abs() };
    let margin = if low < high {
        0.03 * (high - low)
    } else {
        margin_of_one
    };
    low - margin..high + margin
}

/// Formats tick labels with the digits needed to tell apart steps of a twentieth of the axis.
pub(crate) fn tick_label(axis: &Range<f64>) -> impl Fn(&f64) -> String + use<> {
    let step = (axis.end - axis.start) / 20.0;
    let digits = (-step.log10().floor()).max(0.0) as usize;
    move |value| {
        if digits > 4 {
            return format!("{value:.1e}");
        }
        let text = format!("{value:.digits$}");
        // Write "0.0", not "-0.0".
        let zero = text.chars().all(|letter| "-0.".contains(letter));
        text.trim_start_matches(if zero { "-" } else { "" })
            .to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tick_labels_have_the_digits_their_axis_needs() {
        let text = |axis: Range<f64>, value: f64| tick_label(&axis)(&value);
        assert_eq!(text(-1.2..1.0, -1e-17), "0.0");
        assert_eq!(text(-1.2..1.0, -0.4), "-0.4");
        assert_eq!(text(0.0..0.3, 0.05), "0.05");
        assert_eq!(text(0.0..15.0, 14.0), "14.0");
        assert_eq!(text(0.0..150.0, 120.0), "120");
        assert_eq!(text(0.0..1e-5, 2e-6), "2.0e-6");
    }

    #[test]
    fn limits_are_never_empty() {
        for values in [
            vec![],
            vec![f64::NAN],
            vec![0.0],
            vec![-1e9],
            vec![1e-12, 2e-12],
        ] {
            let limits = limits(values.iter().copied());
            assert!(limits.start < limits.end, "{values:?}: {limits:?}");
        }
    }
}
