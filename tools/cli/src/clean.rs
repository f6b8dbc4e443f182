//! `slipstream clean`: what dead runs left behind.

use slipstream_bus::place;

use crate::exit::{Error, Exit};

/// Removes it, and says what it did.
pub(crate) fn run() -> Result<Exit, Error> {
    let failed = |error: std::io::Error| {
        Error::Failed(format!(
            "{}: {error}; check its rights",
            place::SHARED_MEMORY
        ))
    };
    let (foreign, own): (Vec<_>, Vec<_>) = place::leftovers()
        .map_err(failed)?
        .into_iter()
        .partition(|run| run.foreign);
    for run in &own {
        run.remove().map_err(failed)?;
    }
    match own.len() {
        0 => println!("Nothing to clean."),
        1 => println!("Removed what 1 dead run had left."),
        n => println!("Removed what {n} dead runs had left."),
    }
    if !foreign.is_empty() {
        let n = foreign.len();
        println!("Left alone: {n} of another user, who can remove them with slipstream clean.");
    }
    Ok(Exit::Done)
}
