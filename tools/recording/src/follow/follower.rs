//! Turns messages that arrive one by one into short pieces of a recording.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use slipstream_bag::{
    Announced, ChannelInfo, Error, Item, Loss, Undecodable, VisitResult, read_growing,
};
use slipstream_bus::InputError;

use super::channels::Channels;
use super::kept::{Kept, Message};
use crate::carried::{take_model, wheels_in};
use crate::foreign_bag::{
    ForeignFlow, Learning, TopicMap, WheelJoints, WheelNames, is_of_interest,
};
use crate::mcap_file::{OwnFlow, is_stream};
use crate::recording::Recording;
use crate::rows::SpooledRecording;
use crate::topics::{self, StreamMetadata};

/// A piece is at most so long (ns).
const PIECE_NS: u64 = 500_000_000;
/// For so long (ns) messages are kept before it is guessed what their topics are.
const LEARNING_NS: u64 = 5_000_000_000;
/// If time goes back by more (ns), what follows does not continue what was.
const BREAK_NS: u64 = 1_000_000_000;
/// So many notes are said. Topics may be many, and each may be wrong.
const MOST_NOTES: usize = 200;

/// What came of messages.
#[derive(Debug)]
pub enum Followed {
    /// The new rows, with the description of the whole recording. Times count from the first message of the session. A stream
    /// without new rows is empty.
    Rows(Box<Recording>),
    /// What a person should know: a guess, or what is odd.
    Note(String),
    /// Why there will be nothing more.
    Failed(InputError),
}

/// Reads messages as they arrive: of slipstream's own runs, or of another robot. Of the latter it is learnt from the first
/// seconds which topic is which stream, and kept.
pub struct Follower<'a> {
    path: PathBuf,
    name: Option<String>,
    wheels: Vec<WheelJoints>,
    channels: Channels,
    /// Texts that describe the recording.
    texts: Vec<(String, String)>,
    own: Option<OwnFlow>,
    foreign: ForeignFlow,
    is_learnt: bool,
    /// Messages of which it is not known yet what they are.
    kept: Kept,
    kept_since: Option<Instant>,
    /// Log times of the first message of the piece, and of the last one (ns).
    begin_ns: Option<u64>,
    last_ns: u64,
    said: BTreeSet<String>,
    sink: Box<dyn FnMut(Followed) + 'a>,
    has_failed: bool,
}

impl<'a> Follower<'a> {
    /// Nothing is known yet. `path` is used in errors and for the recording's name only; `map` says which topic is which
    /// stream, and `wheels` are the joints of wheels that descriptions of the robots name. `sink` has what comes of it.
    pub fn new(
        path: &Path,
        map: Option<TopicMap>,
        wheels: Vec<WheelJoints>,
        sink: impl FnMut(Followed) + 'a,
    ) -> Self {
        Self {
            path: path.to_owned(),
            name: None,
            wheels,
            channels: Channels::default(),
            texts: Vec::new(),
            own: None,
            foreign: ForeignFlow::new(path.to_owned(), map),
            is_learnt: false,
            kept: Kept::default(),
            kept_since: None,
            begin_ns: None,
            last_ns: 0,
            said: BTreeSet::new(),
            sink: Box::new(sink),
            has_failed: false,
        }
    }

    /// The name of the recording, in place of that of the path.
    pub fn set_name(&mut self, name: &str) {
        self.name = Some(name.to_owned());
    }

    /// Whether there will be nothing more.
    pub fn has_failed(&self) -> bool {
        self.has_failed
    }

    /// The number of a topic for [`message`](Self::message); `None` if its messages are not needed.
    pub fn announced(&mut self, channel: &Announced<'_>) -> Option<u32> {
        self.channel(&ChannelInfo::from(channel))
    }

    /// A text that describes the recording: `recording.toml` or `robot.toml`. Others are left out.
    pub fn described(&mut self, name: &str, text: &str) {
        if ![topics::DESCRIPTION, topics::MODEL].contains(&name) {
            return;
        }
        self.texts.retain(|(known, _)| known != name);
        self.texts.push((name.to_owned(), text.to_owned()));
        if let Some(own) = &mut self.own {
            describe(own, name, text);
        }
    }

    /// A message of a topic, with its log time (ns).
    pub fn message(&mut self, number: u32, log_ns: u64, data: &[u8]) {
        let Some(channel) = self.channels.get(number).map(Arc::clone) else {
            return;
        };
        if self.has_failed {
            return;
        }
        if self.own.is_some() {
            self.own_message(number, &channel, log_ns, data);
            return;
        }
        if self.is_learnt {
            self.cut(log_ns);
            let read = self.foreign.message(0, &channel, signed(log_ns), data);
            self.note_undecodable(read, &channel);
            if self.kept.is_empty() && self.foreign.knows(&channel.topic) {
                return;
            }
        }
        self.kept_since.get_or_insert_with(Instant::now);
        self.kept.add(Message {
            id: number,
            channel,
            log_ns,
            data: data.to_vec(),
        });
        if self.kept.age_ns(log_ns) >= LEARNING_NS || self.kept.is_full() {
            self.learn(false);
        }
    }

    /// To be called now and then while nothing arrives: passes on what is there.
    pub fn idle(&mut self) {
        let wait = Duration::from_nanos(LEARNING_NS);
        if self.kept_since.is_some_and(|since| since.elapsed() >= wait) {
            self.learn(false);
        }
        if self.begin_ns.take().is_some() {
            self.pass_on(false);
        }
    }

    /// Passes on what is left.
    pub fn finish(&mut self) {
        if self.has_failed {
            return;
        }
        if self.own.is_none() && (!self.is_learnt || !self.kept.is_empty()) {
            self.learn(true);
        }
        self.pass_on(true);
    }

    /// Reads an MCAP file whose `source` waits for what is not written yet, and may meanwhile call
    /// [`idle`](Self::idle). Returns what could not be read.
    ///
    /// # Errors
    /// If it is not an MCAP file, or reading fails.
    pub fn read(
        follower: &RefCell<Self>,
        source: impl Read,
        path: &Path,
    ) -> Result<Loss, InputError> {
        let mut numbers: Vec<Option<u32>> = Vec::new();
        read_growing(source, path, &mut |item| {
            let mut follower = follower.borrow_mut();
            match item {
                Item::Channel { id, channel } => {
                    let place = id as usize;
                    if numbers.len() <= place {
                        numbers.resize(place + 1, None);
                    }
                    if let Some(number) = numbers.get_mut(place) {
                        *number = follower.channel(channel);
                    }
                }
                Item::Message {
                    id,
                    log_time_ns,
                    data,
                    ..
                } => {
                    if let Some(Some(number)) = numbers.get(id as usize) {
                        follower.message(*number, log_time_ns, data);
                    }
                }
                Item::Attachment { name, data } => {
                    follower.described(name, &String::from_utf8_lossy(data));
                }
                Item::Metadata { name } if name == topics::FILE_METADATA => follower.become_own(),
                Item::Metadata { .. } | Item::Unwanted { .. } => {}
            }
            Ok(())
        })
    }

    /// The number of a topic; `None` if its messages are not needed.
    fn channel(&mut self, channel: &ChannelInfo) -> Option<u32> {
        if is_stream(channel) {
            self.become_own();
        }
        let is_needed = match self.own {
            Some(_) => StreamMetadata::from_map(&channel.metadata).is_some(),
            None => {
                let map = self.foreign.map();
                is_of_interest(channel, &map.map_or_else(Vec::new, TopicMap::topics))
            }
        };
        if !is_needed {
            return None;
        }
        let Some((number, is_new)) = self.channels.number(channel) else {
            self.note("there are too many topics: some are left out".to_owned());
            return None;
        };
        if is_new && let Some(own) = &mut self.own {
            introduce(own, number, &Arc::new(channel.clone()));
        }
        Some(number)
    }

    /// The messages are those of a run, or of a file that slipstream wrote, unless a map says otherwise.
    fn become_own(&mut self) {
        if self.own.is_some() || self.is_learnt || self.foreign.map().is_some() {
            return;
        }
        let own = self.own.insert(OwnFlow::default());
        for (name, text) in &self.texts {
            describe(own, name, text);
        }
        for (number, channel) in self.channels.all() {
            introduce(own, number, channel);
        }
        for own in std::mem::take(&mut self.kept).into_messages() {
            self.own_message(own.id, &own.channel, own.log_ns, &own.data);
        }
    }

    fn own_message(&mut self, id: u32, channel: &Arc<ChannelInfo>, log_ns: u64, data: &[u8]) {
        self.cut(log_ns);
        let read = self.own.as_mut().map(|own| {
            own.take(Item::Message {
                id,
                channel,
                log_time_ns: log_ns,
                data,
            })
        });
        self.note_undecodable(read.unwrap_or(Ok(())), channel);
    }

    /// Passes on the piece that ends before a message.
    fn cut(&mut self, log_ns: u64) {
        let begin_ns = *self.begin_ns.get_or_insert(log_ns);
        if log_ns.abs_diff(begin_ns) >= PIECE_NS {
            self.pass_on(self.last_ns.saturating_sub(log_ns) > BREAK_NS);
            self.begin_ns = Some(log_ns);
        }
        self.last_ns = log_ns;
    }

    /// Learns what the topics of the kept messages are. `is_last`: there will be no others.
    fn learn(&mut self, is_last: bool) {
        let mut kept = std::mem::take(&mut self.kept);
        self.kept_since = None;
        let path = &self.path;
        let names = WheelNames {
            given: &self.wheels,
            of: &|own| wheels_in(own, path),
        };
        let learnt = match self.foreign.learn(&kept, &names) {
            Ok(Learning::Learnt(learnt)) => learnt,
            Ok(Learning::Nothing(error)) if !is_last => {
                self.note(format!("{error}; waiting for other messages"));
                kept.forget();
                self.kept = kept;
                return;
            }
            // What is guessed wrongly is not what the user can correct.
            Err(error) if self.is_learnt && self.foreign.map().is_none() => {
                self.note(error.to_string());
                return;
            }
            Ok(Learning::Nothing(error)) | Err(error) => return self.fail(error),
        };
        let notes = take_model(&learnt.described, path, self.foreign.description());
        learnt.notes.into_iter().for_each(|note| self.note(note));
        notes.into_iter().for_each(|note| self.note(note));
        let is_first = !self.is_learnt;
        self.is_learnt = true;
        for own in kept.into_messages() {
            if is_first {
                self.cut(own.log_ns);
            }
            let (first, log_ns) = (learnt.first_new, signed(own.log_ns));
            let read = self.foreign.message(first, &own.channel, log_ns, &own.data);
            self.note_undecodable(read, &own.channel);
        }
    }

    /// Passes on the rows that are complete. `is_broken`: nothing continues them.
    fn pass_on(&mut self, is_broken: bool) {
        if self.has_failed {
            return;
        }
        let mut notes = Vec::new();
        let rows = match &mut self.own {
            Some(own) => own.pass_on(&self.path, &mut notes),
            None => Ok(self.foreign.pass_on(is_broken, &mut notes)),
        };
        notes.into_iter().for_each(|note| self.note(note));
        let is_empty = |rows: &SpooledRecording| rows.rows().is_empty();
        let recording = match rows {
            Ok(rows) if is_empty(&rows) => return,
            Ok(rows) => rows.load(),
            Err(error) => Err(error),
        };
        match recording {
            Ok(mut recording) => {
                if let (Some(name), None) = (&self.name, &self.own) {
                    recording.name.clone_from(name);
                }
                (self.sink)(Followed::Rows(Box::new(recording)));
            }
            Err(Error::Input(error)) => self.fail(error),
            Err(error) => {
                let remedy = "check the folder for temporary files (TMPDIR)";
                self.fail(InputError::file(&self.path, error.to_string(), remedy));
            }
        }
    }

    fn note_undecodable(&mut self, read: VisitResult, channel: &ChannelInfo) {
        if let Err(Undecodable) = read {
            let (topic, schema) = (&channel.topic, &channel.schema);
            self.note(format!(
                "{topic}: a message is no {schema}, and is left out"
            ));
        }
    }

    /// Says something once.
    fn note(&mut self, note: String) {
        if self.said.len() < MOST_NOTES && self.said.insert(note.clone()) {
            (self.sink)(Followed::Note(note));
        }
    }

    fn fail(&mut self, error: InputError) {
        self.has_failed = true;
        (self.sink)(Followed::Failed(error));
    }
}

fn signed(log_ns: u64) -> i64 {
    i64::try_from(log_ns).unwrap_or(i64::MAX)
}

fn describe(own: &mut OwnFlow, name: &str, text: &str) {
    let data = text.as_bytes();
    // An attachment has nothing to decode.
    let _ = own.take(Item::Attachment { name, data });
}

fn introduce(own: &mut OwnFlow, number: u32, channel: &Arc<ChannelInfo>) {
    let id = number;
    // A channel has nothing to decode.
    let _ = own.take(Item::Channel { id, channel });
}
