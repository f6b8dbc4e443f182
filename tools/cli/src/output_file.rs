//! Output files, replaced atomically: a file has its old or its new content, never part of it.

use std::fs::Permissions;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use crate::exit::Error;

/// Writes `text` to a temporary file beside `path` and renames it, so that an interruption leaves the
/// previous file. Devices and pipes, such as /dev/stdout, are written directly.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    replace(path, text).map_err(|error| {
        let place = path.display();
        Error::Failed(format!(
            "{place}: cannot be written: {error}; give another file"
        ))
    })
}

/// Writes an answer as indented JSON.
pub(crate) fn write_json(path: &Path, answer: &impl serde::Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(answer)
        .map_err(|error| Error::Failed(format!("{}: {error}", path.display())))?;
    write(path, &(text + "\n"))
}

fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    // follow symbolic links
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if target.exists() && !target.is_file() {
        return std::fs::write(path, text);
    }
    let mut temporary = tempfile::Builder::new()
        .prefix(".slipstream-")
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder(&target))?;
    temporary.write_all(text.as_bytes())?;
    temporary.persist(&target)?;
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    let parent = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    parent.map_or_else(|| PathBuf::from("."), Path::to_owned)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    #[test]
    fn write_replaces_the_file_and_leaves_no_temporary_file() {
        let scratch = tempfile::tempdir().unwrap();
        let file = scratch.path().join("answer.json");
        write(&file, "one").unwrap();
        write(&file, "two").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "two");
        assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 1);
        let refused = write(&scratch.path().join("no/answer.json"), "three");
        assert!(
            refused
                .unwrap_err()
                .to_string()
                .contains("cannot be written")
        );
    }
}
