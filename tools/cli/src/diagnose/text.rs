//! Texts of a diagnosis: verdict, warnings, numbers.

use slipstream_diagnose::{Verdict, Warning};

/// The verdict as a sentence.
pub(super) fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Match => "Match: the model predicts the recording to within sensor noise",
        Verdict::Explained => {
            "Explained: with the findings below, the model predicts the recording to within sensor noise"
        }
        Verdict::Unexplained => {
            "Unexplained: a difference remains that no effect of the catalogue explains"
        }
    }
}

/// A property of a recording that weakens the answer, in one line.
pub(super) fn warning(warning: &Warning) -> String {
    let robot = warning.robot.as_deref().unwrap_or("all robots");
    let (name, what, remedy) = (&warning.recording, &warning.statement, &warning.remedy);
    format!("{name}, {robot}: {what}; {remedy}")
}

/// A number with four significant digits.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let before = if size >= 1.0 {
        size.log10().floor() as usize + 1
    } else {
        0
    };
    let after = if before > 0 {
        4_usize.saturating_sub(before)
    } else {
        leading(size) + 4
    };
    let text = format!("{value:.after$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Number of zeros between the decimal point and the first significant digit.
fn leading(size: f64) -> usize {
    if size == 0.0 {
        0
    } else {
        (-size.log10()).floor().max(0.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.236_14, "0.2361"),
            (0.001_234_56, "0.001235"),
            (-9.1, "-9.1"),
            (1234.56, "1235"),
            (1.02, "1.02"),
            (3e-7, "3.00e-7"),
            (120.0, "120"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
