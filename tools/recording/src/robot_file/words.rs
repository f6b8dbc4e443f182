//! Words of descriptions.

/// Texts with commas; at most six.
pub(super) fn list(texts: impl Iterator<Item = impl Into<String>>) -> String {
    let mut all: Vec<String> = texts.map(Into::into).collect();
    let more = all.len().saturating_sub(6);
    all.truncate(6);
    let text = all.join(", ");
    if more == 0 {
        text
    } else {
        format!("{text} and {more} more")
    }
}

/// The text without what would end a line or steer a terminal.
pub(super) fn one_line(text: &str) -> String {
    text.replace(
        |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}'),
        " ",
    )
}

/// A length in a sentence: to a tenth of a millimetre.
pub(super) fn in_words(length_m: f64) -> String {
    let rounded = (length_m * 1e4).round() / 1e4;
    // No "-0".
    format!("{} m", rounded + 0.0)
}
