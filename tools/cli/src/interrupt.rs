//! Signals: a command ends within a second of Ctrl-C, with exit code 130 and without partial files.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level};
use slipstream_bag::output;

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
    on_signal(|_| end())
}

/// A flag that the first signal sets. The program ends at the second signal, or when `grace` has passed
/// after the first. For commands that have something to finish.
pub(crate) fn stop_flag(grace: Option<Duration>) -> Result<Arc<AtomicBool>, Error> {
    let stop = Arc::new(AtomicBool::new(false));
    let set = Arc::clone(&stop);
    on_signal(move |mut signals| {
        set.store(true, Ordering::Relaxed);
        match grace {
            Some(grace) => std::thread::sleep(grace),
            None => drop(signals.forever().next()),
        }
        end();
    })?;
    Ok(stop)
}

/// What an interruption finds of a command that computes for long.
pub(crate) struct Stop {
    /// Set by the first signal.
    pub(crate) asked: Arc<AtomicBool>,
    keeps: Arc<AtomicBool>,
}

impl Stop {
    /// As [`stop_flag`], until there is something to keep.
    pub(crate) fn new(grace: Duration) -> Result<Self, Error> {
        let stop = Self {
            asked: Arc::new(AtomicBool::new(false)),
            keeps: Arc::new(AtomicBool::new(false)),
        };
        let [asked, keeps] = [&stop.asked, &stop.keeps].map(Arc::clone);
        on_signal(move |mut signals| {
            asked.store(true, Ordering::Relaxed);
            std::thread::sleep(grace);
            if keeps.load(Ordering::Relaxed) {
                let _ = signals.forever().next();
            }
            end();
        })?;
        Ok(stop)
    }

    /// From now on there is something to keep: the command ends by itself when it is asked to, or at the second signal.
    pub(crate) fn keep(&self) {
        self.keeps.store(true, Ordering::Relaxed);
    }
}

/// Calls `act` in a thread of its own after the first signal.
fn on_signal(act: impl FnOnce(Signals) + Send + 'static) -> Result<(), Error> {
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(|error| failed(&error))?;
    std::thread::spawn(move || {
        if signals.forever().next().is_some() {
            act(signals);
        }
    });
    Ok(())
}

fn end() {
    output::remove_unfinished();
    eprint_line!("slipstream: interrupted");
    low_level::exit(Exit::Interrupted.code().into());
}

fn failed(error: &std::io::Error) -> Error {
    Error::Failed(format!("failed to listen for signals: {error}"))
}
