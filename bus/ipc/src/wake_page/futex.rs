//! Futex: sleep while a shared word has a value, and wake the sleepers.

use std::sync::atomic::AtomicU32;
use std::time::Duration;

use rustix::thread::futex::{self, Flags, Timespec};

/// Sleeps while the word has this value, at most for `timeout`. May return early.
pub(super) fn wait(word: &AtomicU32, value: u32, timeout: Duration) {
    let timeout = Timespec {
        tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: i64::from(timeout.subsec_nanos()),
    };
    // Shared between processes, hence no PRIVATE flag. Callers check the word again, whatever ended
    // the wait.
    let _ = futex::wait(word, Flags::empty(), value, Some(&timeout));
}

/// Wakes all sleepers of the word.
pub(super) fn wake_all(word: &AtomicU32) {
    // Waking cannot fail on a mapped and aligned word.
    let _ = futex::wake(word, Flags::empty(), i32::MAX as u32);
}
