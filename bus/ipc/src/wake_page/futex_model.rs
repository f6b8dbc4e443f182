//! Model of the futex for loom: comparing and falling asleep are one step for whoever wakes.
//!
//! The kernel's lock of the word's queue is a mutex, the queue a condition variable. A wait with a
//! time-out of zero returns at once, as an interrupted one does. Any other never times out, so that
//! a lost wake-up is a deadlock, which loom reports.

use std::ops::Deref;
use std::sync::PoisonError;
use std::time::Duration;

use loom::sync::atomic::{AtomicU32, Ordering};
use loom::sync::{Condvar, Mutex};

/// A word that threads can wait for.
#[derive(Debug, Default)]
pub(super) struct Word {
    word: AtomicU32,
    queue: Mutex<()>,
    sleepers: Condvar,
}

impl Deref for Word {
    type Target = AtomicU32;

    fn deref(&self) -> &AtomicU32 {
        &self.word
    }
}

/// Sleeps while the word has this value.
pub(super) fn wait(word: &Word, value: u32, timeout: Duration) {
    if timeout.is_zero() {
        return loom::thread::yield_now();
    }
    let queue = word.queue.lock().unwrap_or_else(PoisonError::into_inner);
    if word.load(Ordering::SeqCst) == value {
        drop(word.sleepers.wait(queue));
    }
}

/// Wakes all sleepers of the word.
pub(super) fn wake_all(word: &Word) {
    let _queue = word.queue.lock().unwrap_or_else(PoisonError::into_inner);
    word.sleepers.notify_all();
}
