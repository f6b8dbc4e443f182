//! `slipstream clean`: what dead runs left behind.

use slipstream_ipc::run_directory;

use crate::exit::{Error, Exit};
use crate::say::say;

/// Removes it, and says what it did.
pub(crate) fn run() -> Result<Exit, Error> {
    let failed = |error: std::io::Error| {
        Error::Failed(format!(
            "{}: {error}; check its rights",
            run_directory::SHARED_MEMORY
        ))
    };
    let (foreign, own): (Vec<_>, Vec<_>) = run_directory::leftovers()
        .map_err(failed)?
        .into_iter()
        .partition(|run| run.foreign);
    for run in &own {
        run.remove().map_err(failed)?;
    }
    match own.len() {
        0 => say!("Nothing to clean."),
        1 => say!("Removed what 1 dead run had left."),
        n => say!("Removed what {n} dead runs had left."),
    }
    if !foreign.is_empty() {
        let n = foreign.len();
        say!("Left alone: {n} of another user, who can remove them with slipstream clean.");
    }
    Ok(Exit::Done)
}
