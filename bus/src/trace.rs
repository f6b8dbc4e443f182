//! The recorded trace: spans and events of the `tracing` crate as compact postcard records.
//!
//! [`begin`] lets a thread's spans and events through the filter of `RUST_LOG` onto a tape of the
//! thread; whoever records takes the tape in, piece by piece, because records one by one cost more
//! than they are worth. A span becomes one record when it closes. Times are the run's: virtual as
//! told with [`at`], or the wall clock's ([`use_clock`]). An event with a field `t_ns` happened then.

mod fields;
mod piece;
mod subscriber;
mod tape;
mod varint;

use tracing::subscriber::DefaultGuard;
pub use tracing_subscriber::EnvFilter;
use tracing_subscriber::layer::SubscriberExt;

pub use self::piece::{Traced, TracedError, Value, read};
use self::subscriber::{Teller, ToTape, with_teller};
use self::tape::PIECE;
pub use self::tape::pieces;
use crate::clock::WallClock;
use crate::record::{Record, Recorder};

/// What stands before every piece of a trace in a file. Other versions begin with less.
pub const FORMAT: u8 = 33;
/// The environment variable with the filter.
pub const VARIABLE: &str = "RUST_LOG";
/// What is recorded where the variable says nothing: all but the finest level.
const DEFAULT: &str = "slipstream=debug";

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
    with_teller(|teller| {
        *teller = Teller::of(process);
    });
    Tracing {
        _guard: tracing::subscriber::set_default(ToTape.with(filter)),
    }
}

/// Tells the virtual time (ns).
pub fn at(now_ns: i64) {
    with_teller(|teller| teller.now_ns = now_ns);
}

/// From now on the clock tells the time.
pub fn use_clock(clock: WallClock) {
    with_teller(|teller| teller.clock = Some(clock));
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
    with_teller(|teller| teller.tape.len()).unwrap_or(0)
}

/// As [`drain`], when there is almost a piece.
pub fn drain_long(each: impl FnMut(i64, &[u8])) {
    if waiting() > PIECE - PIECE / 8 {
        drain(each);
    }
}

/// Shows `each` the tape piece by piece, with the time of the first record (ns), and empties it.
pub fn drain(each: impl FnMut(i64, &[u8])) {
    // Meanwhile something may be told, which then waits for the next time.
    let mut room = take();
    pieces(&room, each);
    room.clear();
    with_teller(|teller| {
        if teller.tape.len() == 0 {
            teller.tape.exchange(room);
        }
    });
}

/// The tape as bytes, for [`pieces`]; the tape is empty then.
pub fn take() -> Vec<u8> {
    with_teller(|teller| teller.tape.exchange(Vec::new())).unwrap_or_default()
}

/// Records that found no room on the tape.
pub fn lost() -> u64 {
    with_teller(|teller| teller.tape.lost).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::fields::LONGEST;
    use super::tape::ROOM;
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
        assert!(
            sizes.len() > 2 && sizes.iter().all(|&size| size <= PIECE),
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
        assert!(take().len() < ROOM + PIECE && lost() > 0);
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
