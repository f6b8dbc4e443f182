//! Invalid input of `slipstream run`: one line with place and remedy, exit code 2, no files left behind.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::slipstream;

/// Expects that a run is refused with one line that contains every text of `expected`.
fn assert_refused(folder: &Path, arguments: &[&str], expected: &[&str]) {
    let before = unfinished_run_directories();
    let output = slipstream(folder, &[&["run"], arguments].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert_eq!(stderr.trim_end().lines().count(), 1, "{stderr}");
    for part in expected {
        assert!(
            stderr.contains(part),
            "{arguments:?}: no {part:?} in {stderr}"
        );
    }
    let new: Vec<String> = unfinished_run_directories()
        .into_iter()
        .filter(|name| !before.contains(name))
        .collect();
    assert!(new.is_empty(), "{new:?}");
    assert!(!folder.join("platoon.mcap").exists());
}

/// Run directories in /dev/shm that are being created. Those of complete runs have other names.
fn unfinished_run_directories() -> Vec<String> {
    let entries = std::fs::read_dir("/dev/shm").unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with("making-")).collect()
}

#[test]
fn errors_name_the_argument() {
    let folder = tempfile::tempdir().unwrap();
    let assert_refused =
        |arguments: &[&str], expected: &[&str]| assert_refused(folder.path(), arguments, expected);
    assert_refused(
        &["--robots", "0"],
        &["--robots 0: robots.count is 0; give 1 to"],
    );
    assert_refused(
        &["--set", "links.delay_s=-0.1"],
        &["--set links.delay_s=-0.1: links.delay_s is -0.1; give a number from 0 to 10000"],
    );
    assert_refused(
        &["--set", "links.dealy_s=0.1"],
        &["links.dealy_s is not a key; did you mean links.delay_s?"],
    );
    assert_refused(
        &["--set", "links.protocol=star"],
        &["links.protocol: unknown variant", "`ring`"],
    );
    assert_refused(
        &["--set", "duration_s=soon"],
        &["duration_s is not a number"],
    );
    assert_refused(
        &["--set", "duration_s"],
        &["--set duration_s: has no =; give --set KEY=VALUE"],
    );
    assert_refused(
        &["--set", "on_death=continue"],
        &["on_death needs the wall clock"],
    );
    assert_refused(&["--robot", "nowhere.toml"], &["nowhere.toml: ", "; "]);
    assert_refused(
        &["--set", "links.trace=nowhere.csv"],
        &["nowhere.csv: ", "seq and rtt_ms"],
    );
    assert_refused(
        &["nowhere.toml"],
        &["nowhere.toml: cannot be read", "platoon, single"],
    );
    assert_refused(
        &["--out", "no/where.mcap"],
        &["--out no/where.mcap: cannot be written"],
    );
    assert_refused(
        &["--in-process", "--clock", "wall"],
        &["--in-process: runs on the virtual clock only"],
    );
}

#[test]
fn errors_name_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    file("a.toml", "duration_s = 3\n[links]\nloss = 1.5\n");
    assert_refused(
        folder.path(),
        &["a.toml"],
        &["a.toml:3: links.loss is 1.5; give a fraction"],
    );
    let payload = "robot = \"r2\"\neffect = \"payload\"\nmass_kg = 1\nx_m = 0\n";
    for (change, said) in [
        (
            format!("at_s = 2\n{payload}"),
            "r2: effects.payload.y_m is missing; give",
        ),
        (
            format!("at_s = 15\n{payload}"),
            "entry 1: at_s is 15; give a time before the end",
        ),
        (
            "at_s = 2\nlink = \"r2 to r1\"\ndelay_s = 1\n".to_owned(),
            "entry 1: link is \"r2 to r1\", which is no link of the run; give one",
        ),
    ] {
        file(
            "c.toml",
            &format!("links.protocol = \"periodic\"\n[[changes]]\n{change}"),
        );
        assert_refused(folder.path(), &["c.toml"], &["c.toml:2: changes ", said]);
    }
    file("b.toml", "\n\n[links]\nlos = 0.5\n");
    assert_refused(
        folder.path(),
        &["b.toml"],
        &["b.toml:4: links.los is not a key; did you mean links.loss"],
    );
    file(
        "e.toml",
        "[assumptions.floor]\nkeys = [\"control.frition\"]\nreason = \"felt\"\n",
    );
    assert_refused(
        folder.path(),
        &["e.toml"],
        &["e.toml:2: control.frition is not a key; did you mean control.friction"],
    );
    file(
        "f.toml",
        "[assumptions.floor]\nkeys = [\"control.friction\"]\n",
    );
    assert_refused(
        folder.path(),
        &["f.toml"],
        &["f.toml:2: assumptions.floor is not an assumption", "reason"],
    );
    file("c.toml", "duration_s = \n");
    assert_refused(folder.path(), &["c.toml"], &["c.toml:1: is not valid TOML"]);
    file("d.toml", "format = 2\n");
    assert_refused(
        folder.path(),
        &["d.toml"],
        &["d.toml:1: format is 2; give format = 1"],
    );
    file("rtt.csv", "seq,rtt_ms\n0,12.5\n1,-3\n");
    assert_refused(
        folder.path(),
        &["--set", "links.trace=rtt.csv"],
        &["rtt.csv:3: rtt_ms is -3; give milliseconds"],
    );
    let robot = "format = 1\n[robot]\nwheel_radius_m = 0.0365\nhalf_track_m = 0.105\n";
    file(
        "r.toml",
        &format!("{robot}[effects]\nwheel_slop = {{ friction = 1 }}\n"),
    );
    assert_refused(folder.path(), &["--robot", "r.toml"], &["wheel_slop"]);
    file("k.toml", robot);
    assert_refused(
        folder.path(),
        &["--robot", "r9=k.toml"],
        &["there is no robot r9; give r1 to r3"],
    );
    assert_refused(folder.path(), &["--robot", "k.toml"], &["encoder"]);
}

/// System limits are checked before any process is started.
#[test]
fn too_few_file_descriptors_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let program = env!("CARGO_BIN_EXE_slipstream");
    let script = format!("ulimit -n 80; exec {program} run --robots 10");
    let output = std::process::Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("ulimit -n: 10 robots need 214 file descriptors, 80"),
        "{stderr}"
    );
}

/// Every key is listed with its origin: built in, file and line, or argument.
#[test]
fn a_dry_run_shows_every_key_and_its_origin() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.toml"), "[links]\ndelay_s = 0.1\n").unwrap();
    let arguments = [
        "run",
        "mine.toml",
        "--dry-run",
        "--seed",
        "9",
        "--set",
        "control.k_x=2",
        "--robots",
        "5",
    ];
    let output = slipstream(folder.path(), &arguments);
    assert!(output.status.success());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = |key: &str| {
        let found = text
            .lines()
            .find(|line| line.starts_with(&format!("{key} = ")));
        found
            .unwrap_or_else(|| panic!("no {key} in {text}"))
            .split_whitespace()
            .collect::<Vec<_>>()
    };
    assert_eq!(line("links.delay_s")[2..], ["0.1", "#", "mine.toml:2"]);
    assert_eq!(line("seed")[2..], ["9", "#", "--seed", "9"]);
    assert_eq!(
        line("control.k_x")[2..],
        ["2.0", "#", "--set", "control.k_x=2"]
    );
    assert_eq!(
        line("links.loss")[2..],
        ["0.0", "#", "built", "in", "(platoon)"]
    );
    // The output is an experiment with the same values.
    std::fs::write(folder.path().join("again.toml"), &text).unwrap();
    let again = slipstream(folder.path(), &["run", "again.toml", "--dry-run"]);
    let values = |text: &str| -> Vec<String> {
        text.lines()
            .map(|line| line.split("  #").next().unwrap().trim_end().to_owned())
            .collect()
    };
    assert_eq!(
        values(&String::from_utf8_lossy(&again.stdout)),
        values(&text)
    );
}

#[test]
fn what_slipstream_did_not_write_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| slipstream(folder.path(), arguments).status.code();
    let single = ["run", "single", "--in-process"];
    let with = |more: &[&'static str]| [&single[..], more].concat();
    assert_eq!(
        run(&with(&["--out", "a.mcap", "--json", "a.json"])),
        Some(0)
    );
    // A recording stays; an answer is written again.
    assert_eq!(run(&with(&["--out", "a.mcap"])), Some(2));
    assert_eq!(run(&with(&["--no-recording", "--json", "a.json"])), Some(0));
    assert_eq!(run(&with(&["--out", "a.mcap", "--force"])), Some(0));
    std::fs::write(folder.path().join("mine.json"), "{\"mine\": 1}\n").unwrap();
    assert_eq!(
        run(&with(&["--no-recording", "--json", "mine.json"])),
        Some(2)
    );
    // Default names are never taken.
    for name in ["single.mcap", "single-2.mcap"] {
        assert_eq!(run(&single), Some(0));
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

#[test]
fn json_goes_to_standard_output_alone() {
    let folder = tempfile::tempdir().unwrap();
    let output = slipstream(folder.path(), &["effects", "push", "--json", "-"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["effects"][0]["id"], "push");
    let quiet = slipstream(folder.path(), &["effects", "-q"]);
    assert!(quiet.stdout.is_empty() && quiet.status.success());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Without the feature `hosts`, runs across hosts are refused with what to build.
#[cfg(not(feature = "hosts"))]
#[test]
fn a_build_for_one_host_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["run", "--host", "b=r2"][..],
        &["join", "tcp/127.0.0.1:7447", "--name", "b"],
        &["keys", "lab-keys"],
    ] {
        let output = slipstream(folder.path(), arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.contains("--features hosts"), "{arguments:?}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
