//! `slipstream clean`: removes the files that dead runs left in shared memory.

use slipstream_ipc::run_directory;

use crate::exit::{Error, Exit};
use crate::print::print_line;

/// Runs the command.
pub(crate) fn run() -> Result<Exit, Error> {
    let failed = |error: std::io::Error| {
        Error::Failed(format!(
            "{}: {error}; check its permissions",
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
        0 => print_line!("Nothing to clean."),
        1 => print_line!("Removed the files of 1 dead run."),
        n => print_line!("Removed the files of {n} dead runs."),
    }
    if !foreign.is_empty() {
        let n = foreign.len();
        print_line!(
            "Kept the files of {n} runs of other users, who can remove them with slipstream clean."
        );
    }
    Ok(Exit::Done)
}
