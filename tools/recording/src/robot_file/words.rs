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
