//! The part that a process plays in a run: what every process is started with, and what it does before and after its
//! work.

use std::path::PathBuf;

use slipstream_bus::transport::BusError;

use crate::presence::Parent;
use crate::{report, trace};

/// What the processes of a run have to agree on: release, and number of changes of messages and files since. Raise the number
/// when one of them changes.
pub const PROTOCOL: &str = concat!(env!("CARGO_PKG_VERSION"), "/3");

/// What every process of a run is started with.
#[derive(Debug, Clone)]
pub struct Membership {
    /// The run directory.
    pub run: PathBuf,
    /// The launcher.
    pub launcher: Parent,
    /// The run is recorded.
    pub recording: bool,
    /// The recording holds a trace.
    pub trace: bool,
}

/// Plays the part of the process `name`: watches the launcher, traces, and does the work. Returns whether it was done; what failed
/// is left for the launcher, which says it.
pub fn play(
    membership: &Membership,
    name: &str,
    work: impl FnOnce() -> Result<(), BusError>,
) -> bool {
    if let Err(error) = membership.launcher.watch() {
        leave_problem(
            membership,
            name,
            &format!("failed to watch the launcher: {error}"),
        );
        return false;
    }
    let filter = match membership.trace.then(trace::filter).transpose() {
        Ok(filter) => filter,
        Err(problem) => {
            leave_problem(membership, name, &format!("{}: {problem}", trace::VARIABLE));
            return false;
        }
    };
    let _tracing = filter.map(|filter| trace::begin(name, filter));
    let process = tracing::info_span!("process").entered();
    let played = work();
    drop(process);
    trace::save(&membership.run, name);
    match played {
        Ok(()) | Err(BusError::Stopped) => true,
        Err(error) => {
            leave_problem(membership, name, &error.to_string());
            false
        }
    }
}

/// Leaves a problem of the process `name` for the launcher. If it cannot be left, it is printed.
pub fn leave_problem(membership: &Membership, name: &str, problem: &str) {
    use std::io::Write as _;
    if report::write_failure(&membership.run, name, problem).is_err() {
        // Standard error may be closed.
        let _ = writeln!(std::io::stderr(), "slipstream {name}: {problem}");
    }
}
