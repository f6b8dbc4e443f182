//! Signals: a command ends within a second of Ctrl-C, with exit code 130 and without partial files.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level};
use slipstream_recording::output;

use crate::exit::{Error, Exit};
use crate::print::eprint_line;

/// A write beyond the file-size limit (`ulimit -f`) becomes an error that can be told, and no longer
/// ends the process.
pub(crate) fn catch_file_size_limit() -> Result<(), Error> {
    let ignored = Arc::new(AtomicBool::new(false));
    flag::register(SIGXFSZ, ignored)
        .map(|_| ())
        .map_err(|error| failed(&error))
}

/// From now on the first signal ends the program. For commands that have nothing to finish.
pub(crate) fn end_at_once() -> Result<(), Error> {
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(|error| failed(&error))?;
    std::thread::spawn(move || {
        if signals.forever().next().is_some() {
            output::remove_unfinished();
            eprint_line!("slipstream: interrupted");
            low_level::exit(Exit::Interrupted.code().into());
        }
    });
    Ok(())
}

/// A flag that the first signal sets; the second one ends the program. For commands that have
/// something to finish.
pub(crate) fn stop_flag() -> Result<Arc<AtomicBool>, Error> {
    let stop = Arc::new(AtomicBool::new(false));
    let code = Exit::Interrupted.code().into();
    for signal in [SIGINT, SIGTERM] {
        flag::register_conditional_shutdown(signal, code, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| failed(&error))?;
    }
    Ok(stop)
}

fn failed(error: &std::io::Error) -> Error {
    Error::Failed(format!("failed to listen for signals: {error}"))
}
