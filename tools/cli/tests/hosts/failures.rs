//! A host that dies, stands still or is cut off ends the run in words on both sides.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::cable::{ADDRESS, Cable};
use crate::common::wait_for;
use crate::{LIMIT, Started, alone, is_root, signal, stderr};

/// A run that goes on for long, with the robots r2 and r3 on the other host. Returns the plant's host and the other.
fn long_run(cable: &Cable, folder: &Path) -> (Started, Started) {
    let plant = cable.plant(
        folder,
        &[
            "run",
            "--listen",
            ADDRESS,
            "--insecure",
            "--host",
            "b=r2,r3",
            "--no-recording",
            "--set",
            "duration_s=100000",
        ],
    );
    std::thread::sleep(Duration::from_millis(300));
    let join = ["join", ADDRESS, "--insecure", "--name", "b"];
    let other = cable.other(folder, &join);
    std::thread::sleep(Duration::from_millis(1500));
    (plant, other)
}

/// Pid of the process of the other host with these arguments.
pub(crate) fn pid_of(pattern: &str) -> u32 {
    let mut pid = None;
    wait_for(pattern, Duration::from_secs(5), || {
        let output = Command::new("pgrep")
            .args(["-f", pattern])
            .output()
            .unwrap();
        pid = String::from_utf8_lossy(&output.stdout)
            .lines()
            .last()
            .and_then(|own| own.parse().ok());
        pid.is_some()
    });
    pid.unwrap()
}

fn assert_fails(child: Started, since: Instant, said: &[&str]) {
    let output = child.wait();
    let (text, taken) = (stderr(&output), since.elapsed());
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(taken < LIMIT, "{taken:?}: {text}");
    for said in said {
        assert!(text.contains(said), "{said}: {text}");
    }
}

#[test]
fn a_host_that_dies_or_stands_still_ends_the_run_in_words_on_both_sides() {
    let _one = alone();
    if !is_root() {
        return;
    }
    type Harm = fn(&Cable);
    let cases: [(Harm, &[&str], &[&str]); 5] = [
        (
            |_| signal(pid_of("slipstream agent .*--robot 2"), "-KILL"),
            &["host b: r3 (pid", "was killed by signal 9"],
            &["r3 (pid", "was killed by signal 9"],
        ),
        (
            |_| signal(pid_of("slipstream relay"), "-KILL"),
            &["host b: its process is gone"],
            &["relay (pid", "was killed by signal 9"],
        ),
        (
            |_| signal(pid_of("slipstream relay"), "-STOP"),
            &["host b: "],
            &["relay (pid"],
        ),
        (
            |_| signal(pid_of("slipstream hosts"), "-KILL"),
            &["hosts (pid", "was killed by signal 9"],
            &["the plant's host: its run is gone"],
        ),
        (
            |cable| cable.set("down"),
            &["host b: it has been silent for 3."],
            &["the plant's host: it has been silent for 3."],
        ),
    ];
    for (harm, at_plant, at_other) in cases {
        let folder = tempfile::tempdir().unwrap();
        let cable = Cable::new();
        let (plant, other) = long_run(&cable, folder.path());
        let begin = Instant::now();
        harm(&cable);
        assert_fails(plant, begin, at_plant);
        assert_fails(other, begin, at_other);
    }
}
