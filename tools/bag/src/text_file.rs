//! Text files, and the pointers that Git LFS leaves in the place of large ones.

use std::io::Read as _;
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

/// Largest text that is read (bytes). The largest descriptions of robots have a few hundred kilobytes.
const MAX_BYTES: u64 = 4 << 20;

/// Reads a text file of bounded size: a description or a map, not data.
///
/// # Errors
/// If the file cannot be read, is not UTF-8, is too large or a pointer of Git LFS.
pub fn read_text(path: &Path) -> Result<String, InputError> {
    let unreadable = |error: std::io::Error| InputError::unreadable(path, &error);
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    let read = file.take(MAX_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(unreadable)?;
    refuse_pointer(&bytes, path)?;
    if bytes.len() as u64 > MAX_BYTES {
        let problem = format!("has more than {MAX_BYTES} bytes, too many for a description");
        let remedy =
            "give the file that describes robot or data (TOML, URDF or YAML), not the data";
        return Err(InputError::file(path, problem, remedy));
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count() as u64;
        InputError::file(path, "is not UTF-8", "save it as UTF-8").at(line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_too_large_or_no_text_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("robot.urdf");
        let error = |content: &[u8]| {
            std::fs::write(&file, content).unwrap();
            read_text(&file).unwrap_err()
        };
        assert!(
            error(&vec![b' '; (4 << 20) + 1])
                .problem
                .starts_with("has more than")
        );
        let pointer = error(b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n");
        assert!(pointer.problem.starts_with("is a pointer of Git LFS"));
        let latin = error(b"<robot>\n<link name=\"r\xe4der\"/>");
        assert_eq!((latin.line, &*latin.problem), (Some(2), "is not UTF-8"));
    }
}
