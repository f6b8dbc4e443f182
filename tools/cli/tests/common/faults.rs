//! Helpers for tests that disturb runs: signals at random moments, and what must be left afterwards.

use std::path::Path;
use std::process::Child;
use std::time::{Duration, SystemTime};

use rustix::process::{Pid, Signal, kill_process};
use slipstream_ipc::run_directory::leftovers;

use super::{Role, command, is_alive, roles, wait_for};

/// A run that lasts longer than any test.
pub(crate) const LONG_RUN: [&str; 6] = [
    "run",
    "--set",
    "duration_s=100000",
    "--out",
    "disturbed.mcap",
    "--seed=3",
];

/// How often a test disturbs: the environment variable, or `otherwise`, which is the short form in CI.
pub(crate) fn count(variable: &str, otherwise: usize) -> usize {
    let given = std::env::var(variable).ok();
    given.and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

/// A random time below `limit`. The clock is random enough for moments that differ from run to run.
pub(crate) fn random_time(limit: Duration) -> Duration {
    let nanos = SystemTime::UNIX_EPOCH.elapsed().unwrap().as_nanos();
    let mixed = (nanos as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    limit.mul_f64(mixed as f64 / f64::from(u32::MAX))
}

/// Sends a signal to a process, which may have ended.
pub(crate) fn signal(pid: u32, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(pid).unwrap()).unwrap();
    let _ = kill_process(pid, signal);
}

/// Starts a run of three robots and waits until all processes run and data is recorded.
pub(crate) fn start(folder: &Path, arguments: &[&str]) -> (Child, Vec<Role>) {
    let child = command(folder, arguments).spawn().unwrap();
    let mut processes = Vec::new();
    let recording = folder.join("disturbed.mcap");
    let mut described = None;
    wait_for("start", Duration::from_secs(60), || {
        processes = roles(child.id());
        let length = std::fs::metadata(&recording).map_or(0, |m| m.len());
        if length > 0 {
            described.get_or_insert(length);
        }
        processes.len() == 5 && described.is_some_and(|described| length > described)
    });
    (child, processes)
}

/// The process of a role: `r1`, `plant` or `recorder`.
pub(crate) fn process<'a>(processes: &'a [Role], name: &str) -> &'a Role {
    processes.iter().find(|process| process.is(name)).unwrap()
}

/// The living processes of a run: those that work in its folder, also before they know their role.
pub(crate) fn processes_in(folder: &Path) -> Vec<u32> {
    let folder = folder.canonicalize().unwrap();
    let works_here = |pid: &u32| {
        std::fs::read_link(format!("/proc/{pid}/cwd")).is_ok_and(|works_in| works_in == folder)
    };
    let names = std::fs::read_dir("/proc").unwrap().flatten();
    let pids = names.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    pids.filter(works_here)
        .filter(|&pid| is_alive(pid))
        .collect()
}

/// The recording of a disturbed run can be read; a run that died before it began one has none.
pub(crate) fn assert_recording(folder: &Path) {
    let path = folder.join("disturbed.mcap");
    if path.exists() {
        let import = slipstream_recording::read(&path).unwrap();
        assert_eq!(import.recording.robots.len(), 3);
    }
}

/// No files of dead runs of this user are in shared memory, but for those of tests that run beside this
/// one and clean up in a moment.
pub(crate) fn assert_no_dead_runs() {
    wait_for("cleaning", Duration::from_secs(10), || {
        leftovers().unwrap().iter().all(|run| run.foreign)
    });
}
