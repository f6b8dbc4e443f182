//! Conversion between seconds in floating point and the whole nanoseconds of a bag.

/// Seconds to the nearest nanosecond, clamped to the range of `i64` (292 years).
pub fn ns_from_s(t_s: f64) -> i64 {
    (t_s * 1e9).round() as i64
}

/// The floating-point number nearest to this time in seconds, as parsing its decimal text gives it.
pub fn s_from_ns(t_ns: i64) -> f64 {
    /// Integers up to 2^53 are exact in floating point, so that the division rounds only once.
    const LARGEST_EXACT: u64 = 1 << 53;
    if t_ns.unsigned_abs() <= LARGEST_EXACT {
        return t_ns as f64 / 1e9;
    }
    let (sign, size) = (if t_ns < 0 { "-" } else { "" }, t_ns.unsigned_abs());
    let text = format!("{sign}{}.{:09}", size / 1_000_000_000, size % 1_000_000_000);
    text.parse().unwrap_or(t_ns as f64 / 1e9)
}

/// Whether a time (s) round-trips through a ROS time stamp bit for bit.
pub fn is_whole_ns(t_s: f64) -> bool {
    let t_ns = ns_from_s(t_s);
    let stamp = super::messages::Time::from_ns(t_ns);
    stamp.ns() == t_ns && s_from_ns(t_ns).to_bits() == t_s.to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_times_with_nine_digits_round_trip() {
        for text in [
            "0.077866",
            "1.797",
            "86400.123456789",
            "1248272272.841",
            "0",
        ] {
            let t_s: f64 = text.parse().unwrap();
            assert!(is_whole_ns(t_s), "{text}");
        }
    }

    #[test]
    fn finer_times_and_times_out_of_range_do_not_round_trip() {
        for t_s in [0.1 + 0.2, 1e-10, -0.0, 3e9, 1e300] {
            assert!(!is_whole_ns(t_s), "{t_s}");
        }
    }
}
