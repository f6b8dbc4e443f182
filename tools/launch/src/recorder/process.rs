//! Process of the recorder: receives records and writes them to the recording until all other
//! processes have ended, however they end.

use std::fs::File;
use std::os::fd::AsFd;
use std::path::Path;
use std::time::{Duration, Instant};

use slipstream_bus::experiment::Clock;
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::transport::BusError;
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::record_pipe::RecordReceiver;
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Member, Stage, WakePage};

use super::mcap_sink::McapSink;
use super::merge::{Merge, SILENCE};
use super::served::Served;
use crate::run_files::read_keys;

/// Sleep when no record arrives.
const IDLE_SLEEP: Duration = Duration::from_millis(1);
/// Interval at which the file is flushed.
const FLUSH_INTERVAL: Duration = Duration::from_millis(250);

/// Final report of the recorder.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RecorderOutcome {
    /// Number of records in the file.
    pub records: u64,
    /// Why the file is incomplete.
    pub failure: Option<String>,
}

/// Records the run in `folder` until all other processes have ended, or the file cannot be written.
/// Standard input is the file, open and locked; `out` is its name.
///
/// # Errors
/// When it cannot join the run or begin the file.
pub(crate) fn run(
    folder: &Path,
    launcher: Parent,
    out: &Path,
    serve: Option<(&str, bool)>,
) -> Result<RecorderOutcome, BusError> {
    let joined = JoinedRun::new(folder, Member::Recorder, launcher)?;
    let keys = read_keys(joined.directory.folder());
    let file = std::io::stdin().as_fd().try_clone_to_owned();
    let file = File::from(file.map_err(|e| BusError::failed("recording", e))?);
    let mut sink = match McapSink::new(file, out, &joined.experiment, &keys) {
        Ok(sink) => sink,
        Err(error) => {
            return Ok(RecorderOutcome {
                records: 0,
                failure: Some(error.to_string()),
            });
        }
    };
    let services = joined.services("recorder")?;
    let receiver = RecordReceiver::new(&services, joined.presence.clone())?;
    let served = serve.map(|(address, waits)| Served::start(&joined, &mut sink, address, waits));
    let served = served.transpose()?;
    joined.wake_page().signal_ready();
    tracing::info!(name: "recording", file = %out.display());
    let sources = joined.experiment.robots.len() + 1;
    let lockstep = joined.experiment.settings.clock == Clock::Virtual;
    let mut merge = Merge::new(if lockstep { sources } else { 0 }, sink);
    let failure = receive_all(&joined, &receiver, &mut merge)
        .err()
        .map(|error| error.to_string());
    for trace in trace::read_saved(&joined.directory) {
        joined.presence.show();
        trace::chunks(&trace, |t_ns, bytes| merge.sink.trace(t_ns, bytes));
    }
    joined.presence.show();
    let finished = merge.finish();
    if let Some(served) = served {
        served.stop();
    }
    Ok(match finished {
        Ok(records) => RecorderOutcome { records, failure },
        Err(error) => RecorderOutcome {
            records: 0,
            failure: Some(error.to_string()),
        },
    })
}

/// Records the deaths of processes, which they cannot record themselves.
struct DeathRecorder {
    /// Number of recorded deaths of the plant and of each robot's agent.
    known: Vec<u32>,
}

impl DeathRecorder {
    fn new(robots: usize) -> Self {
        Self {
            known: vec![0; robots + 1],
        }
    }

    fn record_new(&mut self, wake_page: &WakePage, sink: &mut McapSink) {
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

/// Receives records until all other processes have ended and the queue is empty.
fn receive_all(
    joined: &JoinedRun,
    receiver: &RecordReceiver,
    merge: &mut Merge,
) -> Result<(), BusError> {
    let mut deaths = DeathRecorder::new(joined.experiment.robots.len());
    let mut flushed = Instant::now();
    let mut received = Instant::now();
    loop {
        // Read before the queue is found empty, because nothing can arrive after it. If the launcher
        // is gone, nobody sets the stage; then silence ends the recording.
        let orphaned = received.elapsed() > SILENCE && joined.presence.check_launcher().is_err();
        joined.presence.show();
        let last = joined.wake_page().stage() >= Stage::Drained || orphaned;
        let mut idle = true;
        trace::set_virtual_time(joined.wake_page().progress().0);
        while receiver.poll(|source, entry| merge.push(source as usize, entry))? {
            idle = false;
            received = Instant::now();
        }
        merge.release();
        deaths.record_new(joined.wake_page(), &mut merge.sink);
        trace::drain(|t_ns, bytes| merge.sink.trace(t_ns, bytes));
        if flushed.elapsed() >= FLUSH_INTERVAL {
            merge.sink.flush();
            flushed = Instant::now();
        }
        // A full disk: the run is told now, not at its end.
        let failed = merge.sink.failure().is_some();
        if failed || (idle && last) {
            return Ok(());
        }
        if idle {
            std::thread::sleep(IDLE_SLEEP);
        }
    }
}
