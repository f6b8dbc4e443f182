//! Panics of a controller, as a sentence with place and time of the run.

use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};

use slipstream_bus::time::s_from_ns;

thread_local! {
    /// Time of the run (ns), once it has begun.
    static NOW_NS: Cell<Option<i64>> = const { Cell::new(None) };
    /// What the last panic of this thread said, and where.
    static SAID: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Notes the time of the run (ns).
pub(super) fn note_time(now_ns: i64) {
    NOW_NS.set(Some(now_ns));
}

/// Does the work. A panic is not printed: it becomes a sentence.
pub(super) fn catch<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    std::panic::set_hook(Box::new(|panic| {
        let what = panic.payload_as_str().unwrap_or("no message");
        let place = panic
            .location()
            .map(|at| format!(" ({}:{})", at.file(), at.line()));
        let said = format!("{what}{}", place.unwrap_or_default());
        SAID.set(Some(said));
    }));
    let done = catch_within(work);
    drop(std::panic::take_hook());
    done
}

/// As [`catch`], inside of its work.
pub(super) fn catch_within<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        let said = SAID.take().unwrap_or_default();
        let time = NOW_NS.get().map(|ns| format!(" at {:.3} s", s_from_ns(ns)));
        format!(
            "its controller panicked{}: {said}",
            time.unwrap_or_default()
        )
    })
}
