//! Pointers that Git LFS leaves in the place of large files.

use std::path::Path;

use slipstream_bus::InputError;

/// How a pointer begins.
const BEGINNING: &[u8] = b"version https://git-lfs.github.com/spec/";

/// Refuses a file that begins like a pointer.
///
/// # Errors
/// If it does.
pub(crate) fn refuse_pointer(head: &[u8], path: &Path) -> Result<(), InputError> {
    if !head.starts_with(BEGINNING) {
        return Ok(());
    }
    let problem = "is a pointer of Git LFS, not the file itself";
    Err(InputError::file(path, problem, "run `git lfs pull`"))
}
