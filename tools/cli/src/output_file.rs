//! Output files of the commands.

use std::path::{Path, PathBuf};

use slipstream_bag::output;

use crate::exit::Error;
use crate::print;

/// Writes a text file, whole or not at all.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(output::write_file(path, text.as_bytes())?)
}

/// Where the output of a command goes: what an interrupted one has never replaces what is there, and
/// `trial.json` becomes `trial.interrupted.json`.
pub(crate) fn place(path: &Path, interrupted: bool) -> PathBuf {
    if !(interrupted && path.exists()) {
        return path.to_owned();
    }
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("interrupted.{extension}"))
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
