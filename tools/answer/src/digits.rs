//! Numbers for people: as many digits as their interval lets count.

/// Digits behind the point at most.
const MOST: f64 = 9.0;

/// An estimate and the ends of its interval, with two digits of the interval's width.
///
/// ```
/// let [estimate, low, high] = slipstream_answer::in_digits(0.236_14, [0.231_3, 0.241_4]);
/// assert_eq!((&*estimate, &*low, &*high), ("0.236", "0.231", "0.241"));
/// ```
pub fn in_digits(estimate: f64, [low, high]: [f64; 2]) -> [String; 3] {
    let width = (high - low).abs();
    let digits = if width.is_finite() && width > 0.0 {
        (1.0 - width.log10().floor()).clamp(0.0, MOST) as usize
    } else {
        4
    };
    [estimate, low, high].map(|value| format!("{value:.digits$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_keeps_two_digits() {
        for (estimate, interval, text) in [
            (
                0.009,
                [0.008_999_6, 0.009_000_3],
                ["0.00900000", "0.00899960", "0.00900030"],
            ),
            (152.0, [90.0, 214.0], ["152", "90", "214"]),
            (0.5, [0.5, 0.5], ["0.5000", "0.5000", "0.5000"]),
            (1.0, [f64::NEG_INFINITY, 2.0], ["1.0000", "-inf", "2.0000"]),
        ] {
            assert_eq!(in_digits(estimate, interval), text);
        }
    }
}
