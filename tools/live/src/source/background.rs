//! A source that a thread of its own reads, so that whoever hears it never waits longer than it wants to.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use slipstream_bus::InputError;
use slipstream_recording::Followed;

use super::heard::Heard;

/// So many pieces wait for whoever hears them; then the thread waits.
const MOST_WAITING: usize = 64;
/// How often a thread that waits looks whether it should end.
const LOOKING: Duration = Duration::from_millis(20);

/// What a thread reads.
pub(super) struct Background {
    heard: Receiver<Result<Heard, InputError>>,
    should_end: Arc<AtomicBool>,
}

/// Where the thread puts what it reads.
pub(super) struct Outlet {
    heard: SyncSender<Result<Heard, InputError>>,
    should_end: Arc<AtomicBool>,
}

impl Background {
    /// Begins `work`, which ends once the outlet [is closed](Outlet::is_closed).
    ///
    /// # Errors
    /// If the operating system starts no thread.
    pub(super) fn start(
        name: &str,
        work: impl FnOnce(&Outlet) + Send + 'static,
    ) -> Result<Self, InputError> {
        let (sender, receiver) = sync_channel(MOST_WAITING);
        let should_end = Arc::new(AtomicBool::new(false));
        let outlet = Outlet {
            heard: sender,
            should_end: Arc::clone(&should_end),
        };
        let thread = std::thread::Builder::new().name("source".to_owned());
        let started = thread.spawn(move || work(&outlet));
        started.map_err(|error| {
            let problem = format!("cannot be read beside other work: {error}");
            InputError::new(name, problem, "end other programs")
        })?;
        Ok(Self {
            heard: receiver,
            should_end,
        })
    }

    /// What comes next, within `wait`.
    ///
    /// # Errors
    /// What the thread failed with.
    pub(super) fn hear(&mut self, wait: Duration) -> Result<Heard, InputError> {
        match self.heard.recv_timeout(wait) {
            Ok(heard) => heard,
            Err(RecvTimeoutError::Timeout) => Ok(Heard::Nothing),
            Err(RecvTimeoutError::Disconnected) => Ok(Heard::End),
        }
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        self.should_end.store(true, Ordering::Relaxed);
    }
}

impl Outlet {
    /// Passes on what came of messages.
    pub(super) fn followed(&self, followed: Followed) {
        self.put(match followed {
            Followed::Rows(recording) => Ok(Heard::Rows(*recording)),
            Followed::Note(note) => Ok(Heard::Said(one_line(&note))),
            Followed::Failed(error) => Err(error),
        });
    }

    /// Says something to the user, in one line.
    pub(super) fn say(&self, text: &str) {
        self.put(Ok(Heard::Said(one_line(text))));
    }

    /// Ends with an error.
    pub(super) fn fail(&self, error: InputError) {
        self.put(Err(error));
        self.should_end.store(true, Ordering::Relaxed);
    }

    /// Whether nobody wants to hear more.
    pub(super) fn is_closed(&self) -> bool {
        self.should_end.load(Ordering::Relaxed)
    }

    /// Waits, at most until nobody wants to hear more.
    pub(super) fn wait(&self, time: Duration) {
        let began = Instant::now();
        while let Some(rest) = time.checked_sub(began.elapsed())
            && !rest.is_zero()
            && !self.is_closed()
        {
            std::thread::sleep(rest.min(LOOKING));
        }
    }

    fn put(&self, heard: Result<Heard, InputError>) {
        if self.heard.send(heard).is_err() {
            self.should_end.store(true, Ordering::Relaxed);
        }
    }
}

/// A text may come from elsewhere: it stays one line, and writes nothing but itself to a terminal.
fn one_line(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}
