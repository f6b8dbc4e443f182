//! The recorded trace: spans and events of the `tracing` crate as compact postcard records.
//!
//! [`begin`] lets a thread's spans and events through the filter of `RUST_LOG` onto a tape of the
//! thread; whoever records takes the tape in, piece by piece, because records one by one cost more
//! than they are worth. A span becomes one record when it closes. Times are the run's: virtual as
//! told with [`at`], or the wall clock's ([`use_clock`]). An event with a field `t_ns` happened then.

use std::borrow::Cow;
use std::cell::RefCell;
use std::fmt::{Debug, Write as _};

use serde::{Deserialize, Serialize};
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing::subscriber::DefaultGuard;
use tracing::{Event, Level, Metadata, Subscriber};
pub use tracing_subscriber::EnvFilter;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};

use crate::clock::WallClock;
use crate::record::{Record, Recorder};

/// What stands before every piece of a trace in a file. What is from before there was a mark begins
/// with less.
pub const FORMAT: u8 = 32;
/// The environment variable with the filter.
pub const VARIABLE: &str = "RUST_LOG";
/// What is recorded where the variable says nothing: all but the finest level.
const DEFAULT: &str = "slipstream=debug";
/// Bytes that wait on a tape before records are dropped.
const ROOM: usize = 1 << 20;
/// A piece of a tape is no longer than this, or one record (bytes).
const PIECE: usize = 2 << 10;
/// No record is longer (bytes).
const LARGEST: usize = 3 << 10;
/// Before each record: its time (8 bytes) and its length (2).
const PREFIX: usize = 10;
/// No text in a record is longer (bytes).
const LONGEST: usize = 512;

/// A record of the trace.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Traced<'a> {
    /// When it began (ns). On the tape it stands before the record.
    #[serde(skip)]
    pub begin_ns: i64,
    /// Who told it: `plant`, a robot, `recorder`, `launcher`, or `run` where all is one process.
    #[serde(borrow)]
    pub process: Cow<'a, str>,
    /// From 1 (error) to 5 (trace).
    pub level: u8,
    /// The span's or event's name.
    #[serde(borrow)]
    pub name: Cow<'a, str>,
    /// When it closed (ns); none for an event.
    pub end_ns: Option<i64>,
    /// What else it says.
    #[serde(borrow)]
    pub fields: Vec<(Cow<'a, str>, Value<'a>)>,
}

/// The value of a field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Value<'a> {
    /// A whole number.
    Int(i64),
    /// A number.
    Float(f64),
    /// Yes or no.
    Bool(bool),
    /// Anything else.
    Text(#[serde(borrow)] Cow<'a, str>),
}

/// Why a trace record cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TracedError {
    /// It is of another program version.
    #[error("its trace is of another format than {FORMAT}, the one that this program reads")]
    OtherFormat,
    /// It is damaged.
    #[error("a record of its trace is damaged")]
    Damaged,
}

/// Shows `each` the records of a piece of a trace as it stands in a file.
///
/// # Errors
/// A piece of another format, or a damaged one.
pub fn read<'a>(piece: &'a [u8], mut each: impl FnMut(Traced<'a>)) -> Result<(), TracedError> {
    let mut rest = match piece.split_first() {
        Some((&FORMAT, rest)) => rest,
        Some(_) => return Err(TracedError::OtherFormat),
        None => return Err(TracedError::Damaged),
    };
    while !rest.is_empty() {
        let (begin_ns, bytes, after) = split(rest).ok_or(TracedError::Damaged)?;
        match postcard::take_from_bytes(bytes) {
            Ok((record, [])) => each(Traced { begin_ns, ..record }),
            _ => return Err(TracedError::Damaged),
        }
        rest = after;
    }
    Ok(())
}

/// The first record of a tape: its time (ns) and bytes; and the rest.
fn split(tape: &[u8]) -> Option<(i64, &[u8], &[u8])> {
    let (t_ns, rest) = tape.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let (record, rest) = rest.split_at_checked(u16::from_le_bytes(*length).into())?;
    Some((i64::from_le_bytes(*t_ns), record, rest))
}

impl<'a> Traced<'a> {
    /// The value of a field.
    pub fn field(&self, name: &str) -> Option<&Value<'a>> {
        let found = self.fields.iter().find(|(field, _)| field == name);
        found.map(|(_, value)| value)
    }

    /// The value of a field that is a whole number.
    pub fn int(&self, name: &str) -> Option<i64> {
        match self.field(name) {
            Some(Value::Int(value)) => Some(*value),
            _ => None,
        }
    }

    /// The value of a field that is text.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.field(name) {
            Some(Value::Text(value)) => Some(value),
            _ => None,
        }
    }
}

/// The part of a record before its fields.
#[derive(Serialize)]
struct Head<'a> {
    process: &'a str,
    level: u8,
    name: &'a str,
    end_ns: Option<i64>,
}

/// What a thread has told and nobody has taken in.
#[derive(Debug, Default)]
struct Tape {
    process: String,
    now_ns: i64,
    clock: Option<WallClock>,
    /// Spans that have not closed, the newest last, and room for more.
    open: Vec<Open>,
    spare: Vec<Fields>,
    /// Of the event under way.
    fields: Fields,
    records: Vec<u8>,
    lost: u64,
}

#[derive(Debug)]
struct Open {
    id: u64,
    metadata: &'static Metadata<'static>,
    begin_ns: i64,
    fields: Fields,
}

/// Fields, encoded one after the other.
#[derive(Debug, Default)]
struct Fields {
    bytes: Vec<u8>,
    count: u32,
    t_ns: Option<i64>,
    text: String,
}

thread_local! {
    static TAPE: RefCell<Tape> = RefCell::default();
}

/// While it lives, the thread's spans and events are recorded.
#[must_use]
#[derive(Debug)]
pub struct Tracing {
    _guard: DefaultGuard,
}

/// The filter of the environment.
///
/// # Errors
/// A variable that is no filter: what it is, and why.
pub fn filter() -> Result<EnvFilter, String> {
    let told = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty());
    let text = told.as_deref().unwrap_or(DEFAULT);
    let built = EnvFilter::builder().parse(text);
    built.map_err(|error| format!("`{text}` is no filter: {error}"))
}

/// Begins the trace of this thread as `process`.
pub fn begin(process: &str, filter: EnvFilter) -> Tracing {
    with_tape(|tape| {
        *tape = Tape {
            process: process.to_owned(),
            ..Tape::default()
        };
    });
    let subscriber = tracing_subscriber::registry().with(filter).with(TapeLayer);
    Tracing {
        _guard: tracing::subscriber::set_default(subscriber),
    }
}

/// Tells the virtual time (ns).
pub fn at(now_ns: i64) {
    with_tape(|tape| tape.now_ns = now_ns);
}

/// From now on the clock tells the time.
pub fn use_clock(clock: WallClock) {
    with_tape(|tape| tape.clock = Some(clock));
}

/// Tells what a record of the plant says about a torque's way. The plant itself knows of no trace.
pub(crate) fn tell(record: &Record) {
    if let Record::Applied {
        taken_ns,
        robot,
        tick_ns,
        ..
    } = *record
    {
        tracing::debug!(name: "applied", t_ns = taken_ns, robot, tick_ns);
    }
}

/// Gives a record to a recorder, and what it says to the trace; then the tape, if that is long.
pub fn record(recorder: &mut impl Recorder, record: &Record) {
    tell(record);
    recorder.record(record);
    drain_long(|t_ns, bytes| recorder.trace(t_ns, bytes));
}

/// Bytes on the tape.
pub fn waiting() -> usize {
    let mut waiting = 0;
    with_tape(|tape| waiting = tape.records.len());
    waiting
}

/// As [`drain`], when there is more than half a piece.
pub fn drain_long(each: impl FnMut(i64, &[u8])) {
    if waiting() > PIECE / 2 {
        drain(each);
    }
}

/// Shows `each` the tape piece by piece, with the time of the first record (ns), and empties it.
pub fn drain(each: impl FnMut(i64, &[u8])) {
    let mut records = Vec::new();
    // An empty tape keeps its room.
    with_tape(|tape| {
        if !tape.records.is_empty() {
            std::mem::swap(&mut tape.records, &mut records);
        }
    });
    if records.is_empty() {
        return;
    }
    pieces(&records, each);
    records.clear();
    with_tape(|tape| {
        if tape.records.is_empty() {
            std::mem::swap(&mut tape.records, &mut records);
        }
    });
}

/// The tape as bytes, for [`pieces`]; the tape is empty then.
pub fn take() -> Vec<u8> {
    let mut records = Vec::new();
    with_tape(|tape| std::mem::swap(&mut tape.records, &mut records));
    records
}

/// Shows `each` the pieces of a tape's bytes with the time of the first record (ns), as far as they
/// are whole.
pub fn pieces(mut tape: &[u8], mut each: impl FnMut(i64, &[u8])) {
    while let Some((first_ns, _, _)) = split(tape) {
        let mut rest = tape;
        while let Some((_, _, after)) = split(rest) {
            let long = tape.len() - after.len() > PIECE;
            if long && rest.len() < tape.len() {
                break;
            }
            rest = after;
        }
        each(first_ns, &tape[..tape.len() - rest.len()]);
        tape = rest;
    }
}

/// Records that found no room on the tape.
pub fn lost() -> u64 {
    let mut lost = 0;
    with_tape(|tape| lost = tape.lost);
    lost
}

/// Whoever tells something while the tape is in use is not heard.
fn with_tape(work: impl FnOnce(&mut Tape)) {
    // A thread that is ending has no tape any more.
    let _ = TAPE.try_with(|tape| {
        if let Ok(mut tape) = tape.try_borrow_mut() {
            work(&mut tape);
        }
    });
}

/// Writes spans and events onto the thread's tape.
struct TapeLayer;

impl<S: Subscriber> Layer<S> for TapeLayer {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, _: Context<'_, S>) {
        with_tape(|tape| {
            let mut fields = tape.spare.pop().unwrap_or_default();
            fields.clear();
            attributes.record(&mut fields);
            let begin_ns = tape.now_ns();
            tape.open.push(Open {
                id: id.into_u64(),
                metadata: attributes.metadata(),
                begin_ns,
                fields,
            });
        });
    }

    fn on_record(&self, id: &Id, values: &tracing::span::Record<'_>, _: Context<'_, S>) {
        with_tape(|tape| {
            let mut open = tape.open.iter_mut().rev();
            if let Some(span) = open.find(|span| span.id == id.into_u64()) {
                values.record(&mut span.fields);
            }
        });
    }

    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        with_tape(|tape| {
            let mut fields = std::mem::take(&mut tape.fields);
            fields.clear();
            event.record(&mut fields);
            let t_ns = fields.t_ns.unwrap_or_else(|| tape.now_ns());
            tape.write(event.metadata(), t_ns, None, &fields);
            tape.fields = fields;
        });
    }

    fn on_close(&self, id: Id, _: Context<'_, S>) {
        with_tape(|tape| {
            let place = tape.open.iter().rposition(|span| span.id == id.into_u64());
            if let Some(place) = place {
                let span = tape.open.remove(place);
                let end_ns = tape.now_ns();
                tape.write(span.metadata, span.begin_ns, Some(end_ns), &span.fields);
                tape.spare.push(span.fields);
            }
        });
    }
}

impl Tape {
    fn now_ns(&self) -> i64 {
        self.clock.map_or(self.now_ns, |clock| clock.now_ns())
    }

    fn write(
        &mut self,
        metadata: &Metadata<'_>,
        begin_ns: i64,
        end_ns: Option<i64>,
        fields: &Fields,
    ) {
        let start = self.records.len();
        if start > ROOM {
            self.lost += 1;
            return;
        }
        let head = Head {
            process: &self.process,
            level: level(metadata),
            name: metadata.name(),
            end_ns,
        };
        let records = &mut self.records;
        records.extend_from_slice(&begin_ns.to_le_bytes());
        records.extend_from_slice(&[0; 2]);
        // Writing to memory cannot fail. A sequence is its length and its elements.
        let _ = postcard::to_io(&head, &mut *records);
        let _ = postcard::to_io(&fields.count, &mut *records);
        records.extend_from_slice(&fields.bytes);
        match u16::try_from(records.len() - start - PREFIX) {
            Ok(length) if usize::from(length) <= LARGEST => {
                records[start + 8..start + PREFIX].copy_from_slice(&length.to_le_bytes());
            }
            _ => {
                records.truncate(start);
                self.lost += 1;
            }
        }
    }
}

fn level(metadata: &Metadata<'_>) -> u8 {
    match *metadata.level() {
        Level::ERROR => 1,
        Level::WARN => 2,
        Level::INFO => 3,
        Level::DEBUG => 4,
        Level::TRACE => 5,
    }
}

impl Fields {
    fn clear(&mut self) {
        self.bytes.clear();
        self.count = 0;
        self.t_ns = None;
    }

    fn put(&mut self, field: &Field, value: &Value<'_>) {
        // Writing to memory cannot fail.
        let _ = postcard::to_io(&(field.name(), value), &mut self.bytes);
        self.count += 1;
    }
}

impl Visit for Fields {
    fn record_i64(&mut self, field: &Field, value: i64) {
        if field.name() == "t_ns" {
            self.t_ns = Some(value);
        }
        self.put(field, &Value::Int(value));
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.put(field, &Value::Int(i64::try_from(value).unwrap_or(i64::MAX)));
    }

    fn record_f64(&mut self, field: &Field, value: f64) {
        self.put(field, &Value::Float(value));
    }

    fn record_bool(&mut self, field: &Field, value: bool) {
        self.put(field, &Value::Bool(value));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        let value = &value[..value.floor_char_boundary(LONGEST)];
        self.put(field, &Value::Text(Cow::Borrowed(value)));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        // Writing to a string fails only where `value` does.
        let _ = write!(text, "{value:?}");
        self.record_str(field, &text);
        self.text = text;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_a_file(piece: &[u8]) -> Vec<u8> {
        [&[FORMAT], piece].concat()
    }

    fn records() -> Vec<Traced<'static>> {
        let mut all = Vec::new();
        drain(|t_ns, piece| {
            let before = all.len();
            read(Vec::leak(in_a_file(piece)), |record| all.push(record)).unwrap();
            assert_eq!(all[before].begin_ns, t_ns);
        });
        all
    }

    #[test]
    fn spans_and_events_come_with_times_and_fields() {
        let _tracing = begin("r1", EnvFilter::new("debug"));
        at(100);
        let span = tracing::debug_span!("outer", robot = 0_u32, message = tracing::field::Empty);
        let entered = span.enter();
        at(150);
        tracing::info!(name: "sent", t_ns = 140_i64, share = 0.5, lost = false, "to {}", "r2");
        tracing::trace!(name: "fine", robot = 0_u32);
        span.record("message", 7_u32);
        at(200);
        drop(entered);
        drop(span);
        let all = records();
        assert_eq!(all.len(), 2);
        let [sent, outer] = [&all[0], &all[1]];
        assert_eq!(
            (&*sent.name, sent.begin_ns, sent.end_ns),
            ("sent", 140, None)
        );
        assert_eq!(sent.text("message"), Some("to r2"));
        assert_eq!(sent.field("share"), Some(&Value::Float(0.5)));
        assert_eq!(sent.field("lost"), Some(&Value::Bool(false)));
        assert_eq!((outer.begin_ns, outer.end_ns), (100, Some(200)));
        assert_eq!(
            (outer.int("robot"), outer.int("message")),
            (Some(0), Some(7))
        );
        assert_eq!((&*outer.process, outer.level), ("r1", 4));
        assert!(records().is_empty());
    }

    #[test]
    fn what_is_of_another_format_is_told_from_damage() {
        let told = |bytes: &[u8]| read(bytes, |_| {});
        assert_eq!(told(&[5, 1, 2]), Err(TracedError::OtherFormat));
        assert_eq!(told(&[FORMAT, 200]), Err(TracedError::Damaged));
        assert_eq!(told(&[]), Err(TracedError::Damaged));
    }

    #[test]
    fn a_long_tape_comes_in_pieces_of_whole_records() {
        let _tracing = begin("r1", EnvFilter::new("debug"));
        for seq in 0..1000_u32 {
            tracing::debug!(name: "sent", seq);
        }
        let long = "x".repeat(LONGEST);
        let long = long.as_str();
        tracing::debug!(name: "long", a = long, b = long, c = long, d = long, e = long);
        tracing::debug!(name: "too_long", a = long, b = long, c = long, d = long, e = long, f = long);
        let mut sizes = Vec::new();
        let tape = take();
        let mut count = 0;
        pieces(&tape, |_, piece| {
            sizes.push(piece.len());
            read(&in_a_file(piece), |_| count += 1).unwrap();
        });
        assert_eq!((count, lost()), (1001, 1));
        assert_eq!(sizes.iter().sum::<usize>(), tape.len());
        assert!(
            sizes[..sizes.len() - 1].iter().all(|&size| size <= PIECE),
            "{sizes:?}"
        );
    }

    #[test]
    fn without_a_tape_nothing_is_kept_and_a_full_one_counts() {
        tracing::error!("nobody listens");
        assert!(take().is_empty());
        let _tracing = begin("r1", EnvFilter::new("debug"));
        for _ in 0..100_000 {
            tracing::info!(name: "much", text = "more than a tape has room for");
        }
        assert!(take().len() < ROOM + LONGEST && lost() > 0);
    }

    #[test]
    fn a_cut_tape_is_read_as_far_as_it_is_whole() {
        let _tracing = begin("r1", EnvFilter::new("debug"));
        tracing::info!(name: "one", robot = 1_u32);
        tracing::info!(name: "two", robot = 2_u32);
        let bytes = take();
        for cut in 0..bytes.len() {
            let mut count = 0;
            pieces(&bytes[..cut], |_, piece| {
                read(&in_a_file(piece), |_| count += 1).unwrap();
            });
            assert!(count < 2);
        }
    }
}
