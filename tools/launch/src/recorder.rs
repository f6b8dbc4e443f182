//! The recorder's process: takes records from the bus and writes them down, whoever dies.
//!
//! What the others told the trace before they were on the bus, or after they left it, and what the
//! launcher told, lies in files of the run's folder when all are gone.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use slipstream_bus::experiment::Clock;
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::transport::BusError;
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::record_pipe::{Entry, RecordReceiver};
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Stage, WakePage};

use crate::place_files::read_keys;
use crate::sink::Sink;
use crate::tape::read_tapes;

/// How long the recorder sleeps when nothing comes.
const NAP: Duration = Duration::from_millis(1);
/// What was written is made safe at least so often.
const SAFE: Duration = Duration::from_millis(250);
/// A source that is silent for so long does not hold up the others.
const SILENCE: Duration = Duration::from_millis(300);

/// What the recorder has to say at its end.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RecorderOutcome {
    /// Records in the file.
    pub records: u64,
    /// Why the file is not what it should be.
    pub failure: Option<String>,
}

/// Records the run in `folder` to `out` until everybody else is gone.
///
/// # Errors
/// When it cannot join the run or begin the file.
pub fn run(folder: &Path, out: &Path) -> Result<RecorderOutcome, BusError> {
    let joined = JoinedRun::new(folder)?;
    let failed = |e: slipstream_recording::Error| BusError::Failed {
        what: "recording".to_owned(),
        reason: e.to_string(),
    };
    let keys = read_keys(&joined.directory);
    let sink = Sink::create(out, &joined.experiment, &keys).map_err(failed)?;
    let services = joined.services("recorder")?;
    let receiver = RecordReceiver::new(&services)?;
    joined.wake_page.signal_ready();
    tracing::info!(name: "recording", file = %out.display());
    let sources = joined.experiment.robots.len() + 1;
    let lockstep = joined.experiment.settings.clock == Clock::Virtual;
    let mut order = Order::new(if lockstep { sources } else { 0 }, sink);
    let failure = pump(&joined, &receiver, &mut order)
        .err()
        .map(|error| error.to_string());
    for tape in read_tapes(&joined.directory) {
        trace::chunks(&tape, |t_ns, bytes| order.keep_trace(t_ns, bytes));
    }
    Ok(match order.finish() {
        Ok(records) => RecorderOutcome { records, failure },
        Err(error) => RecorderOutcome {
            records: 0,
            failure: Some(error.to_string()),
        },
    })
}

/// Writes down deaths, of which nobody else can tell.
struct Obituary {
    /// Of the plant first, then of the robots' agents: how many are written down.
    known: Vec<u32>,
}

impl Obituary {
    fn new(robots: usize) -> Self {
        Self {
            known: vec![0; robots + 1],
        }
    }

    fn write(&mut self, wake_page: &WakePage, sink: &mut Sink) {
        let processes = std::iter::once(None).chain((0u32..).map(Some));
        for (known, robot) in self.known.iter_mut().zip(processes) {
            let deaths = wake_page.deaths(robot.map(|robot| robot as usize));
            for _ in *known..deaths {
                let (t_ns, kind) = (wake_page.progress().0, EventKind::Died);
                tracing::error!(name: "died", t_ns, robot);
                sink.record(&Record::Event { t_ns, robot, kind });
            }
            *known = deaths;
        }
    }
}

/// Takes records in until everybody else is gone and nothing is left.
fn pump(joined: &JoinedRun, receiver: &RecordReceiver, order: &mut Order) -> Result<(), BusError> {
    let mut obituary = Obituary::new(joined.experiment.robots.len());
    let mut safe = Instant::now();
    let mut heard = Instant::now();
    loop {
        // Asked before the queue is found empty: nothing can come after that. Without a launcher
        // nobody says so; then silence does.
        let orphaned = joined.parent.is_gone() && heard.elapsed() > SILENCE;
        let last = joined.wake_page.stage() >= Stage::Drained || orphaned;
        let mut idle = true;
        trace::set_virtual_time(joined.wake_page.progress().0);
        while receiver.poll(|source, entry| order.take(source as usize, entry))? {
            idle = false;
            heard = Instant::now();
        }
        order.release();
        obituary.write(&joined.wake_page, &mut order.sink);
        trace::drain(|t_ns, bytes| order.sink.trace(t_ns, bytes));
        if safe.elapsed() >= SAFE {
            order.sink.flush();
            safe = Instant::now();
        }
        if idle && last {
            return Ok(());
        }
        if idle {
            std::thread::sleep(NAP);
        }
    }
}

/// Merges the sources by time, so that the file does not depend on who ran when.
struct Order {
    sink: Sink,
    /// How far each source has come (ns).
    reached_ns: Vec<i64>,
    waiting: Vec<(i64, usize, Kept)>,
    released: Instant,
}

/// What waits for its turn.
enum Kept {
    Record(Record),
    Trace { t_ns: i64, bytes: Box<[u8]> },
}

impl Order {
    /// Without `sources` nothing is held back.
    fn new(sources: usize, sink: Sink) -> Self {
        Self {
            sink,
            reached_ns: vec![-1; sources],
            waiting: Vec::new(),
            released: Instant::now(),
        }
    }

    fn take(&mut self, source: usize, entry: Entry<'_>) {
        let (t_ns, kept) = match entry {
            Entry::Record(record) => (record.t_ns(), Kept::Record(record)),
            Entry::Trace { t_ns, bytes } => {
                let bytes = bytes.into();
                (t_ns, Kept::Trace { t_ns, bytes })
            }
        };
        let Some(reached_ns) = self.reached_ns.get_mut(source) else {
            self.write(&kept);
            return;
        };
        *reached_ns = t_ns.max(*reached_ns);
        self.waiting.push((*reached_ns, source, kept));
    }

    fn write(&mut self, kept: &Kept) {
        match kept {
            Kept::Record(record) => self.sink.record(record),
            Kept::Trace { t_ns, bytes } => self.sink.trace(*t_ns, bytes),
        }
    }

    /// Takes in what belongs to no source.
    fn keep_trace(&mut self, t_ns: i64, bytes: &[u8]) {
        self.sink.trace(t_ns, bytes);
    }

    /// Writes what no source can come before any more.
    fn release(&mut self) {
        let silent = self.released.elapsed() > SILENCE;
        let all = self.reached_ns.iter().copied().min().filter(|_| !silent);
        let before_ns = all.unwrap_or(i64::MAX);
        if !self.waiting.iter().any(|&(t_ns, ..)| t_ns < before_ns) {
            return;
        }
        self.released = Instant::now();
        self.waiting
            .sort_by_key(|&(t_ns, source, _)| (t_ns, source));
        let ready = self.waiting.partition_point(|&(t_ns, ..)| t_ns < before_ns);
        let rest = self.waiting.split_off(ready);
        for (_, _, kept) in std::mem::replace(&mut self.waiting, rest) {
            self.write(&kept);
        }
    }

    fn finish(mut self) -> slipstream_recording::Result<u64> {
        self.reached_ns.clear();
        self.release();
        self.sink.finish(BTreeMap::new())
    }
}
