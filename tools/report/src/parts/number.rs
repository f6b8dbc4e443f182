//! Numbers as people read them: as many digits as count, thousands apart, a true minus.

/// Minus sign of the typographer.
const MINUS: char = '−';

/// A number with so many digits behind the point, with thousands apart and a true minus.
///
/// ```
/// assert_eq!(slipstream_report::parts::fixed(-12345.678, 1), "−12,345.7");
/// assert_eq!(slipstream_report::parts::fixed(f64::NAN, 1), "–");
/// ```
pub fn fixed(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{:.digits$}", value.abs());
    let (whole, rest) = text.split_at(text.find('.').unwrap_or(text.len()));
    let is_zero = text.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    let mut out = String::new();
    if value < 0.0 && !is_zero {
        out.push(MINUS);
    }
    for (place, digit) in whole.chars().enumerate() {
        if place > 0 && (whole.len() - place) % 3 == 0 && whole.len() > 4 {
            out.push(',');
        }
        out.push(digit);
    }
    out + rest
}

/// A number with two digits that count; all digits before the point stay.
///
/// ```
/// use slipstream_report::parts::short;
/// assert_eq!(short(0.01234), "0.012");
/// assert_eq!(short(18.63), "18.6");
/// assert_eq!(short(432.1), "432");
/// assert_eq!(short(0.0), "0");
/// ```
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return fixed(value, 0);
    }
    let order = size.log10().floor();
    let digits = match order {
        order if order >= 2.0 => 0,
        order if order >= 0.0 => 1,
        order if order >= -6.0 => (1.0 - order) as usize,
        _ => return format!("{value:.1e}").replace('-', "−"),
    };
    fixed(value, digits)
}

/// Digits behind the point that an interval lets count: its half width to one digit, two if it begins with 1.
///
/// ```
/// use slipstream_report::parts::digits_of;
/// assert_eq!(digits_of([156.4, 158.4]), 1);
/// assert_eq!(digits_of([0.944, 0.976]), 3);
/// assert_eq!(digits_of([60.0, 120.0]), 0);
/// ```
pub fn digits_of([low, high]: [f64; 2]) -> usize {
    let half = (high - low).abs() / 2.0;
    if half <= 0.0 || !half.is_finite() {
        return 4;
    }
    let order = half.log10().floor();
    let first = half / 10.0_f64.powf(order);
    let more = if first < 2.0 { 1.0 } else { 0.0 };
    (more - order).clamp(0.0, 9.0) as usize
}

/// How lengths and angles are shown: factor and unit. Lengths in centimetres, angles in degrees.
///
/// ```
/// use slipstream_report::parts::shown_unit;
/// assert_eq!(shown_unit("m"), (100.0, "cm"));
/// assert_eq!(shown_unit("rad").1, "°");
/// ```
pub fn shown_unit(unit: &str) -> (f64, &'static str) {
    let degree = 1.0_f64.to_degrees();
    match unit {
        "m" => (100.0, "cm"),
        "rad" => (degree, "°"),
        "rad/s" => (degree, "degrees/s"),
        "m/s" => (100.0, "cm/s"),
        "m/s²" => (1.0, "m/s²"),
        _ => (1.0, ""),
    }
}

/// The text of an interval.
pub fn interval(low: f64, high: f64, digits: usize) -> String {
    format!("{} to {}", fixed(low, digits), fixed(high, digits))
}

/// Words that begin a sentence.
///
/// ```
/// assert_eq!(slipstream_report::parts::capital("the wheels slip"), "The wheels slip");
/// ```
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next();
    first.map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_apart_from_five_digits_on() {
        for (value, digits, text) in [
            (1234.0, 0, "1234"),
            (12345.0, 0, "12,345"),
            (1_234_567.25, 2, "1,234,567.25"),
            (-0.04, 1, "0.0"),
            (-0.06, 1, "−0.1"),
        ] {
            assert_eq!(fixed(value, digits), text);
        }
    }

    #[test]
    fn digits_follow_the_interval() {
        // half width 0.13: two digits, because it begins with 1
        assert_eq!(digits_of([0.0, 0.26]), 2);
        // half width 0.4: one digit
        assert_eq!(digits_of([0.0, 0.8]), 1);
        assert_eq!(digits_of([1.0, 1.0]), 4);
    }
}
