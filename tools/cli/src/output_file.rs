//! Output files of the commands.

use std::path::Path;

use slipstream_bus::InputError;
use slipstream_recording::output;

use crate::exit::Error;

/// Writes a text file, whole or not at all.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(output::write_file(path, text.as_bytes())?)
}

/// Writes a text file that is new: an existing one is replaced only with `--force`.
pub(crate) fn write_new(path: &Path, text: &str, force: bool) -> Result<(), Error> {
    if !force && path.symlink_metadata().is_ok() {
        let remedy = "give another file, or --force to replace it";
        return Err(InputError::file(path, "exists", remedy).into());
    }
    write(path, text)
}

/// Writes an answer as indented JSON.
pub(crate) fn write_json(path: &Path, answer: &impl serde::Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(answer)
        .map_err(|error| Error::Failed(format!("{}: {error}", path.display())))?;
    write(path, &(text + "\n"))
}
