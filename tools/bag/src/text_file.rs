//! Text files, and the pointers that Git LFS leaves in the place of large ones.

use std::path::Path;

use slipstream_bus::InputError;

/// How a pointer begins.
const BEGINNING: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Refuses a file that begins like a pointer.
///
/// # Errors
/// If it does.
pub fn refuse_pointer(head: &[u8], path: &Path) -> Result<(), InputError> {
    if !head.starts_with(BEGINNING) {
        return Ok(());
    }
    let problem = "is a pointer of Git LFS, not the file itself";
    Err(InputError::file(path, problem, "run `git lfs pull`"))
}

/// Largest text that is read (bytes). Models and descriptions have a few kilobytes.
const MAX_BYTES: u64 = 4 << 20;

/// Reads a text file of bounded size.
///
/// # Errors
/// If the file cannot be read, is not UTF-8, is too large or a pointer of Git LFS.
pub fn read_text(path: &Path) -> Result<String, InputError> {
    let size = std::fs::metadata(path).map_err(|e| InputError::unreadable(path, &e))?;
    if size.len() > MAX_BYTES {
        return Err(InputError::file(
            path,
            format!("has {} bytes, too many for a TOML file", size.len()),
            "give a TOML file, not the data",
        ));
    }
    let text = std::fs::read_to_string(path).map_err(|e| InputError::unreadable(path, &e))?;
    refuse_pointer(text.as_bytes(), path)?;
    Ok(text)
}
