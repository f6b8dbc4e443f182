//! Futex: sleep while a shared word has a value, and wake the sleepers.

use std::ops::Deref;
use std::sync::atomic::AtomicU32;
use std::time::Duration;

use rustix::thread::futex::{self, Flags, Timespec};

/// A word that processes can wait for.
#[derive(Debug, Default)]
#[repr(transparent)]
pub(super) struct Word(AtomicU32);

impl Deref for Word {
    type Target = AtomicU32;

    fn deref(&self) -> &AtomicU32 {
        &self.0
    }
}

/// Sleeps while the word has this value, at most for `timeout`. May return early.
pub(super) fn wait(word: &Word, value: u32, timeout: Duration) {
    let timeout = Timespec {
        tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: i64::from(timeout.subsec_nanos()),
    };
    // Shared between processes, hence no PRIVATE flag. Callers check the word again, whatever ended
    // the wait.
    let _ = futex::wait(word, Flags::empty(), value, Some(&timeout));
}

/// Wakes all sleepers of the word.
pub(super) fn wake_all(word: &Word) {
    // Waking cannot fail on a mapped and aligned word.
    let _ = futex::wake(word, Flags::empty(), i32::MAX as u32);
}
