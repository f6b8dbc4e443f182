//! The property of every error.

/// Asserts that an error is one line.
pub(crate) fn assert_one_line(error: &impl std::fmt::Display) {
    let text = error.to_string();
    assert!(!text.contains('\n'), "an error of several lines: {text}");
}
