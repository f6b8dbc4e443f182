//! Lines that fit a terminal.

use std::borrow::Cow;

use console::measure_text_width;

/// Narrower terminals get lines as they are (columns).
const NARROWEST: usize = 40;

/// The text with its long lines broken between words. What follows is indented as the line is, and after the sign of a
/// list by two more.
pub(crate) fn wrapped(text: &str, columns: usize) -> Cow<'_, str> {
    let is_long = |line: &str| measure_text_width(line) > columns;
    if columns < NARROWEST || !text.lines().any(is_long) {
        return Cow::Borrowed(text);
    }
    let lines = text.split('\n').map(|line| match is_long(line) {
        true => Cow::Owned(broken(line, columns)),
        false => Cow::Borrowed(line),
    });
    Cow::Owned(lines.collect::<Vec<_>>().join("\n"))
}

/// One line as several. A word that is longer than a line stays whole, so that a path can be copied.
fn broken(line: &str, columns: usize) -> String {
    let content = line.trim_start();
    let indent = line.len() - content.len();
    let hanging = match content.starts_with("- ") {
        true => indent + 2,
        false => indent.max(2),
    };
    let mut text = " ".repeat(indent);
    let mut width = indent;
    // Cells of a table stand apart by several blanks, which stay where the line is not broken.
    for word in content.split_inclusive(' ') {
        let own = measure_text_width(word.trim_end());
        if width > hanging && width + own > columns {
            text.truncate(text.trim_end().len());
            text.push('\n');
            text.push_str(&" ".repeat(hanging));
            width = hanging;
        }
        text.push_str(word);
        width += measure_text_width(word);
    }
    text.truncate(text.trim_end().len());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words() {
        let short = "a line that fits\nand another\n";
        assert_eq!(wrapped(short, 40), short);
        let text = "  - one two three four five six seven eight nine ten eleven\nshort\n";
        assert_eq!(
            wrapped(text, 40),
            "  - one two three four five six seven\n    eight nine ten eleven\nshort\n"
        );
        let path = format!("written to {} and more", "/a".repeat(30));
        let lines = format!("written to\n  {}\n  and more", "/a".repeat(30));
        assert_eq!(wrapped(&path, 40), lines);
        assert_eq!(wrapped(&path, 20), path);
    }

    #[test]
    fn bold_words_take_no_more_room() {
        let bold = console::Style::new().bold().force_styling(true);
        let text = format!(
            "{} and words up to forty columns in all",
            bold.apply_to("bold")
        );
        assert_eq!(wrapped(&text, 44), text);
    }
}
