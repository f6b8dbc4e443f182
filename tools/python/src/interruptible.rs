//! Work on a thread of its own while Python listens for Ctrl-C: the interpreter is free meanwhile.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::{Failed, failed};

/// How often Python looks for signals.
const LISTENING: Duration = Duration::from_millis(50);

/// Unwinds work that nobody waits for any more; no panic hook hears of it.
struct GivenUp;

/// Whether the work was given up. Work calls [`Stop::check`] where it can end.
#[derive(Clone, Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Ends the work here if it was given up.
    pub(crate) fn check(&self) {
        if self.0.load(Ordering::Relaxed) {
            resume_unwind(Box::new(GivenUp));
        }
    }

    /// The flag itself, for work that looks at one.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.0
    }
}

/// Does `work` on another thread. A signal such as Ctrl-C raises its exception at once; the work then ends at its next
/// step.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> T + Send + 'static,
) -> PyResult<T> {
    let stop = Stop::default();
    let own = stop.clone();
    let (done, mut result) = channel();
    let thread = std::thread::Builder::new().name("slipstream".to_owned());
    let spawned = thread.spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(|| work(&own)));
        // nobody listens any more when the work was given up
        let _ = done.send(outcome);
    });
    spawned.map_err(|error| failed(&error))?;
    loop {
        let received;
        (received, result) = py.detach(move || (result.recv_timeout(LISTENING), result));
        match received {
            Ok(Ok(value)) => return Ok(value),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(Failed::new_err(
                    "the work ended in a panic: please report it",
                ));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(signal) = py.check_signals() {
            stop.flag().store(true, Ordering::Relaxed);
            return Err(signal);
        }
    }
}
