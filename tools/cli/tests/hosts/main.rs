//! Runs across hosts as a user starts them. The hosts are two network namespaces with a cable between them; the second
//! has a time namespace whose monotonic clock is 1,000 s ahead.
//!
//! Needs the feature `hosts` (`just hosts`); the tests with namespaces need root.
#![cfg(feature = "hosts")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;

mod cable;
mod failures;
mod refusals;
mod ssh;
mod states;
mod wall;

use std::path::Path;
use std::process::{Child, Command, Output};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use common::{is_root, run_json};

/// Time in which a host ends after another has failed, with `host_timeout_s` at its default of 3 s.
const LIMIT: Duration = Duration::from_secs(5);

/// The tests run one after the other: one of them kills processes that it finds by name.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A free port of this computer.
fn port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// A process that ends with the test, even if that fails.
struct Started(Option<Child>);

impl Started {
    fn new(command: &mut Command) -> Self {
        Self(Some(command.spawn().unwrap()))
    }

    fn id(&self) -> u32 {
        self.0.as_ref().unwrap().id()
    }

    /// Waits for its end.
    fn wait(mut self) -> Output {
        self.0.take().unwrap().wait_with_output().unwrap()
    }
}

impl Drop for Started {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_done(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
}

/// The state hash of the run in one process.
fn hash_alone(folder: &Path, arguments: &[&str]) -> String {
    let alone = run_json(
        folder,
        &[arguments, &["--in-process", "--no-recording"]].concat(),
    );
    alone["state_hash"].as_str().unwrap().to_owned()
}

fn signal(pid: u32, name: &str) {
    let status = Command::new("kill").args([name, &pid.to_string()]).status();
    assert!(status.unwrap().success());
}
