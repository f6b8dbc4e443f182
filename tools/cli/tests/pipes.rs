//! Closed pipes: the reader of the output may stop reading. `slipstream effects | head -1` once panicked.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slipstream"));
    command.current_dir(folder).args(arguments);
    command
}

/// The write end of a pipe whose read end is closed.
fn closed_pipe() -> Stdio {
    std::io::pipe().unwrap().1.into()
}

#[test]
fn a_closed_pipe_stops_the_output_only() {
    let folder = tempfile::tempdir().unwrap();
    let run = [
        "run",
        "--in-process",
        "--set",
        "duration_s=1",
        "--out",
        "a.mcap",
        "--force",
    ];
    for arguments in [
        &["effects"][..],
        &run,
        &["check", "a.mcap"],
        &["trace", "a.mcap", "--json", "trace.json"],
        &["--help"],
    ] {
        let output = command(folder.path(), arguments)
            .stdout(closed_pipe())
            .output()
            .unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            (output.status.code(), &*stderr),
            (Some(0), ""),
            "{arguments:?}"
        );
        let both = command(folder.path(), arguments)
            .stdout(closed_pipe())
            .stderr(closed_pipe())
            .status();
        assert_eq!(both.unwrap().code(), Some(0), "{arguments:?}");
    }
    assert!(folder.path().join("trace.json").exists());
    let refused = command(folder.path(), &["trace", "nothing"])
        .stderr(closed_pipe())
        .status();
    assert_eq!(refused.unwrap().code(), Some(2));
}

#[test]
fn a_full_disk_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let full = File::options().write(true).open("/dev/full").unwrap();
    let output = command(folder.path(), &["effects"])
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.starts_with("slipstream: standard output: cannot be written: "),
        "{stderr}"
    );
}
