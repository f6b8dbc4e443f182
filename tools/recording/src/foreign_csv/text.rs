//! Whether a file is text, whatever its name ends with.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use slipstream_bus::InputError;

/// So many bytes tell.
const HEAD_BYTES: u64 = 1 << 10;

/// Whether a file begins with text. An empty one does not.
///
/// # Errors
/// If it cannot be read, or is text in an encoding of two bytes a letter.
pub(crate) fn is_text(path: &Path) -> Result<bool, InputError> {
    let unreadable = |e| InputError::unreadable(path, &e);
    let file = File::open(path).map_err(unreadable)?;
    let mut head = Vec::new();
    let mut file = file.take(HEAD_BYTES);
    file.read_to_end(&mut head).map_err(unreadable)?;
    // A logger that lost its power leaves zeros at the end.
    let written = head.iter().rposition(|byte| *byte != 0);
    head.truncate(written.map_or(0, |last| last + 1));
    if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        let problem = "is text in UTF-16";
        return Err(InputError::file(path, problem, "save it as UTF-8"));
    }
    let is_of_text =
        |byte: &u8| matches!(byte, b'\t' | b'\n' | 11 | 12 | b'\r' | b' '..=126 | 128..);
    Ok(!head.is_empty() && head.iter().all(is_of_text))
}
