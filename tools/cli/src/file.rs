//! Files that somebody named: whole or not at all.

use std::fs::Permissions;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use crate::exit::Error;

/// Writes `text` beside `path` and then puts it in its place, so that an end in between leaves what
/// was there before. What is no file, such as /dev/stdout, is written as it is.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    replace(path, text).map_err(|error| {
        let place = path.display();
        Error::Failed(format!(
            "{place}: cannot be written: {error}; give another file"
        ))
    })
}

/// Writes an answer as JSON.
pub(crate) fn write_json(path: &Path, answer: &impl serde::Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(answer)
        .map_err(|error| Error::Failed(format!("{}: {error}", path.display())))?;
    write(path, &(text + "\n"))
}

fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    // behind a link, the file itself
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if place.exists() && !place.is_file() {
        return std::fs::write(path, text);
    }
    let mut making = tempfile::Builder::new()
        .prefix(".slipstream-")
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder(&place))?;
    making.write_all(text.as_bytes())?;
    making.persist(&place)?;
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
    #![allow(
        clippy::unwrap_used,
        reason = "a test stops at what it does not expect"
    )]
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
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
