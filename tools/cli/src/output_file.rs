//! Output files of the commands.

use std::path::Path;

use slipstream_recording::output;

use crate::exit::Error;

/// Writes a text file, whole or not at all.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(output::write_file(path, text.as_bytes())?)
}

/// Writes an answer as indented JSON.
pub(crate) fn write_json(path: &Path, answer: &impl serde::Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(answer)
        .map_err(|error| Error::Failed(format!("{}: {error}", path.display())))?;
    write(path, &(text + "\n"))
}
