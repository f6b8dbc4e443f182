//! Output files of the commands.

use std::path::Path;

use slipstream_recording::output;

use crate::exit::Error;
use crate::print;

/// Writes a text file, whole or not at all.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(output::write_file(path, text.as_bytes())?)
}

/// Writes an answer as indented JSON; to standard output, if the path is `-`.
pub(crate) fn write_json(path: &Path, answer: &impl serde::Serialize) -> Result<(), Error> {
    let text = serde_json::to_string_pretty(answer)
        .map_err(|error| Error::Failed(format!("{}: {error}", path.display())))?;
    if path == Path::new("-") {
        print::raw(format_args!("{text}\n"));
        return Ok(());
    }
    write(path, &(text + "\n"))
}
