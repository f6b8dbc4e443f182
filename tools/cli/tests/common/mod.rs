//! Helpers for tests of the command line: run `slipstream`, watch its processes, read its output.
#![allow(dead_code, reason = "no test file uses every helper")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

pub(crate) mod browser;
pub(crate) mod faults;
pub(crate) mod programs;
pub(crate) mod schemas;
pub(crate) mod viewer;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Prints that a test is skipped because a program is missing.
///
/// # Panics
/// If `CI` is set: there a skipped test is a failure.
pub(crate) fn skipped(reason: &str) {
    assert!(std::env::var_os("CI").is_none(), "skipped: {reason}");
    eprintln!("SKIPPED: {reason}");
}

/// Whether the tests run as root; says so if not.
pub(crate) fn is_root() -> bool {
    let root = rustix::process::geteuid().is_root();
    if !root {
        eprintln!("SKIPPED: needs root");
    }
    root
}

/// The command `slipstream` with these arguments, in a folder.
pub(crate) fn command(folder: &Path, arguments: &[&str]) -> Command {
    command_behind(&[], folder, arguments)
}

/// As [`command`], behind the words of `before`, such as those of `ip netns exec`.
pub(crate) fn command_behind(before: &[&str], folder: &Path, arguments: &[&str]) -> Command {
    let words = [before, &[env!("CARGO_BIN_EXE_slipstream")], arguments].concat();
    let mut command = Command::new(words[0]);
    command
        .current_dir(folder)
        .args(&words[1..])
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Runs `slipstream` to its end.
pub(crate) fn slipstream(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// Runs `slipstream run`, which must succeed, and reads the JSON that it writes.
pub(crate) fn run_json(folder: &Path, arguments: &[&str]) -> Value {
    let mut all = vec!["run", "--json", "result.json"];
    all.extend(arguments);
    let output = slipstream(folder, &all);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    read_json(&folder.join("result.json"))
}

pub(crate) fn read_json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A process of a run, read from /proc.
#[derive(Debug, Clone)]
pub(crate) struct Role {
    pub(crate) pid: u32,
    /// The arguments; the first is the role.
    pub(crate) arguments: Vec<String>,
}

impl Role {
    /// `plant`, `agent` or `recorder`.
    pub(crate) fn name(&self) -> &str {
        &self.arguments[0]
    }

    /// Whether it is the process of this name in messages: `plant`, `recorder`, or a robot such as `r1`.
    pub(crate) fn is(&self, name: &str) -> bool {
        let robot = self.arguments.windows(2).find(|pair| pair[0] == "--robot");
        match robot {
            Some(pair) => format!("r{}", pair[1].parse::<u32>().unwrap() + 1) == name,
            None => self.name() == name,
        }
    }

    /// Whether it is a program that is asked for its parameters.
    pub(crate) fn describes(&self) -> bool {
        self.arguments.iter().any(|word| word == "--describe")
    }

    /// The run directory.
    pub(crate) fn folder(&self) -> &str {
        let at = self
            .arguments
            .iter()
            .position(|word| word == "--run")
            .unwrap();
        &self.arguments[at + 1]
    }
}

/// The child processes of a launcher.
pub(crate) fn roles(launcher: u32) -> Vec<Role> {
    let path = format!("/proc/{launcher}/task/{launcher}/children");
    let pids = std::fs::read_to_string(path).unwrap_or_default();
    let role = |pid: &str| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).ok()?;
        let words = line.split(|&byte| byte == 0).skip(1);
        let arguments: Vec<String> = words
            .map(|word| String::from_utf8_lossy(word).into_owned())
            .collect();
        let named = arguments
            .first()
            .is_some_and(|name| name != "run" && !name.is_empty());
        named.then_some(Role {
            pid: pid.parse().ok()?,
            arguments,
        })
    };
    pids.split_whitespace().filter_map(role).collect()
}

/// Whether a process exists and is not a zombie.
pub(crate) fn is_alive(pid: u32) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit(')')
        .next()
        .is_some_and(|state| !state.is_empty() && !state.starts_with(" Z"))
}

/// Files in /dev/shm that belong to the run in `folder`.
pub(crate) fn shared_memory(folder: &str) -> Vec<String> {
    let name = folder.rsplit('/').next().unwrap();
    let entries = std::fs::read_dir("/dev/shm").unwrap();
    let names =
        entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()));
    names.filter(|other| other.contains(name)).collect()
}

/// Waits until `done` returns true and returns how long that took.
///
/// # Panics
/// After `limit`.
pub(crate) fn wait_for(what: &str, limit: Duration, mut done: impl FnMut() -> bool) -> Duration {
    let begin = Instant::now();
    while !done() {
        assert!(
            begin.elapsed() < limit,
            "{what} takes longer than {limit:?}"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    begin.elapsed()
}

/// Two threads that spin until the value is dropped.
pub(crate) struct Load {
    stop: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl Load {
    pub(crate) fn new() -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let threads = (0..2)
            .map(|_| {
                let stop = Arc::clone(&stop);
                std::thread::spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                })
            })
            .collect();
        Self { stop, threads }
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
