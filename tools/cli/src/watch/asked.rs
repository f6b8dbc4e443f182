//! Diagnoses of changes, beside the rows that go on.

use std::sync::mpsc::{Receiver, channel};

use slipstream_bus::InputError;
use slipstream_diagnose::{Answer, Event, Question, Watch};

/// What a diagnosis was asked, and what it said.
type Confirmation = (Question, Result<Answer, InputError>);

/// One diagnosis at a time: on a thread of its own where rows go on; else at once, so that what is said depends on the rows
/// alone.
pub(super) struct Asked {
    is_live: bool,
    waiting: Option<Receiver<Confirmation>>,
}

impl Asked {
    pub(super) fn new(is_live: bool) -> Self {
        Self {
            is_live,
            waiting: None,
        }
    }

    /// Asks what is due, and hears what was answered; at the end of the rows, waits for it.
    pub(super) fn step(&mut self, watch: &mut Watch, ended: bool) -> Vec<Event> {
        let mut events = self.answered(watch, ended);
        while self.waiting.is_none() {
            let Some(question) = watch.question() else {
                break;
            };
            if !self.is_live {
                let answer = question.diagnose();
                events.extend(watch.answered(&question, &answer));
                continue;
            }
            let (sender, receiver) = channel();
            std::thread::spawn(move || {
                let answer = question.diagnose();
                // nobody waits for it any more where the watch has ended
                let _ = sender.send((question, answer));
            });
            self.waiting = Some(receiver);
            if ended {
                events.extend(self.answered(watch, ended));
            }
        }
        events
    }

    fn answered(&mut self, watch: &mut Watch, ended: bool) -> Vec<Event> {
        let Some(receiver) = &self.waiting else {
            return Vec::new();
        };
        let answered = if ended {
            receiver.recv().ok()
        } else {
            match receiver.try_recv() {
                Ok(own) => Some(own),
                Err(std::sync::mpsc::TryRecvError::Empty) => return Vec::new(),
                Err(std::sync::mpsc::TryRecvError::Disconnected) => None,
            }
        };
        self.waiting = None;
        answered.map_or_else(Vec::new, |(question, answer)| {
            watch.answered(&question, &answer)
        })
    }
}
