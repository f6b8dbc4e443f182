//! `slipstream trial` on the command line: commitments, reproducible seeds, scores, interruption.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::time::Duration;

use common::{command, read_json, slipstream};
use sha2::{Digest, Sha256};

/// All files below a folder, by relative path.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// Expects exit code 2 and an error that contains `expected`.
fn assert_refused(folder: &Path, arguments: &[&str], expected: &str) {
    let output = slipstream(folder, &[&["trial"], arguments].concat());
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(
        stderr.contains(expected),
        "{arguments:?}: no {expected:?} in {stderr}"
    );
}

#[test]
fn a_seed_gives_the_same_files_and_commitments_match_the_labels() {
    let folder = tempfile::tempdir().unwrap();
    for out in ["one", "two"] {
        let output = slipstream(
            folder.path(),
            &[
                "trial",
                "--cases",
                "3",
                "--seed",
                "5",
                "--make-only",
                "--out",
                out,
            ],
        );
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let (one, two) = (
        files(&folder.path().join("one")),
        files(&folder.path().join("two")),
    );
    assert!(one == two, "the same seed made different files");
    let commitments = String::from_utf8(one["commitments.txt"].clone()).unwrap();
    assert_eq!(commitments.lines().count(), 3);
    for line in commitments.lines() {
        let (digits, name) = line.split_once("  ").unwrap();
        let sealed = &one[&format!("sealed/{name}.txt")];
        let hash: String = Sha256::digest(sealed)
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        assert_eq!(digits, hash, "{name}");
        assert!(one.contains_key(&format!("robots/{name}.toml")));
        assert!(one.contains_key(&format!("{name}/recording.toml")));
    }
    assert_refused(
        folder.path(),
        &["--cases", "1", "--make-only", "--out", "one"],
        "one: the folder is not empty; give a new folder",
    );
}

/// A plan that is a list is cut to as many cases; logs are as reproducible as other cases.
#[test]
fn every_plan_makes_as_many_cases_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    for (plan, out) in [("kinematic", "list"), ("logs", "one"), ("logs", "two")] {
        let cases = ["trial", "--plan", plan, "--cases", "2"];
        let made = [&cases[..], &["--make-only", "--out", out]].concat();
        assert!(slipstream(folder.path(), &made).status.success());
    }
    let [list, one, two] = ["list", "one", "two"].map(|out| files(&folder.path().join(out)));
    assert!(one == two, "the same seed made different files");
    for made in [list, one] {
        let commitments = String::from_utf8(made["commitments.txt"].clone()).unwrap();
        assert_eq!(commitments.lines().count(), 2);
    }
}

/// One new case from start to end, then the same case again from its labels.
#[test]
fn a_trial_and_its_repetition_from_labels_have_the_same_scores() {
    let folder = tempfile::tempdir().unwrap();
    let held = ["trial", "--cases", "1", "--seed", "9", "--limit-s", "120"];
    let output = slipstream(
        folder.path(),
        &[&held[..], &["--out", "held", "--json", "held.json"]].concat(),
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let report = read_json(&folder.path().join("held.json"));
    assert_eq!(report["format"], 1);
    assert_eq!(report["cases"], 1);
    let published =
        std::fs::read_to_string(folder.path().join("held").join("commitments.txt")).unwrap();
    let commitment = report["commitments"][0].as_str().unwrap();
    assert!(published.starts_with(commitment));
    let again = [
        "trial",
        "--labels",
        "held/labels.toml",
        "--json",
        "again.json",
    ];
    assert!(slipstream(folder.path(), &again).status.success());
    let again = read_json(&folder.path().join("again.json"));
    for key in [
        "exact",
        "inexact",
        "missed",
        "wrong",
        "false_alarms",
        "failed",
        "confusion",
    ] {
        assert_eq!(report[key], again[key], "{key}");
    }
}

/// Writes a shell script with the arguments of `slipstream diagnose` that runs `answer`, and a case without
/// effects.
fn write_program(folder: &Path, answer: &str) {
    let script = format!("#!/bin/sh\n[ \"$5\" = --json ] || exit 3\n{answer}\n");
    let path = folder.join("program");
    std::fs::write(&path, script).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    let folder = folder.join("case");
    if !folder.exists() {
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("recording.toml"), "format = 1\n").unwrap();
    }
    std::fs::write(folder.with_file_name("robot.toml"), "format = 1\n").unwrap();
    let labels = "[case]\nverdict = \"match\"\nrobot_toml = \"robot.toml\"\n";
    std::fs::write(folder.with_file_name("labels.toml"), labels).unwrap();
}

const WITH: [&str; 7] = [
    "trial",
    "--labels",
    "labels.toml",
    "--with",
    "program",
    "--json",
    "trial.json",
];

#[test]
fn answers_of_another_program_are_scored() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = |answer: &str, limit: &str| {
        write_program(folder.path(), answer);
        let output = slipstream(folder.path(), &[&WITH[..], &["--limit-s", limit]].concat());
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        read_json(&folder.path().join("trial.json"))["each"][0].clone()
    };
    let exact = outcome("echo '{\"verdict\": \"match\"}' > \"$6\"", "60");
    assert_eq!(exact["outcome"], "exact");
    let alarm = outcome("echo '{\"verdict\": \"unexplained\"}' > \"$6\"", "60");
    assert_eq!(alarm["outcome"], "false_alarm");
    let failed = outcome("echo 'no idea' >&2; exit 1", "60");
    assert_eq!(failed["outcome"], "failed");
    assert!(failed["remarks"][0].as_str().unwrap().contains("no idea"));
    let slow = outcome("exec sleep 60", "1");
    assert_eq!(slow["remarks"][0], "no answer in 1 s");
    // The program sees the recording and the model, but no label.
    let isolated = outcome(
        "[ \"$(ls)\" = \"recording\nrobot.toml\nwords.txt\" ] || { ls >&2; exit 1; }\necho '{\"verdict\": \"match\"}' > \"$6\"",
        "60",
    );
    assert_eq!(isolated["outcome"], "exact", "{isolated}");
}

/// Interrupts a trial once `ready` holds, and waits for its end.
fn interrupt_when(mut child: Child, ready: impl Fn() -> bool) -> Output {
    while !ready() {
        if child.try_wait().unwrap().is_some() {
            panic!("{:?}", child.wait_with_output().unwrap());
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupt.success());
    child.wait_with_output().unwrap()
}

#[test]
fn a_trial_interrupted_before_its_first_answer_leaves_no_scores() {
    let folder = tempfile::tempdir().unwrap();
    let begun = folder.path().join("begun");
    write_program(
        folder.path(),
        &format!("touch '{}'; exec sleep 60", begun.display()),
    );
    let child = command(folder.path(), &WITH).spawn().unwrap();
    let output = interrupt_when(child, || begun.exists());
    assert_eq!(output.status.code(), Some(130));
    assert!(!folder.path().join("trial.json").exists());
}

/// A program that answers two cases; the third one does not end. The place of the answer comes after `--json`.
fn third_hangs(folder: &Path) -> String {
    format!(
        "echo >> '{0}'; [ $(wc -l < '{0}') -lt 3 ] || exec sleep 60; echo '{{\"verdict\": \"match\"}}' > \"$6\"",
        folder.join("begun").display()
    )
}

/// Runs a trial with that program, interrupts it in the third case, and checks what it prints.
fn interrupt_at_third(folder: &Path, arguments: &[&str]) {
    let begun = folder.join("begun");
    let child = command(folder, arguments).spawn().unwrap();
    let is_third = || std::fs::read_to_string(&begun).is_ok_and(|text| text.lines().count() == 3);
    let output = interrupt_when(child, is_third);
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    for words in ["2 cases", "Interrupted: the remaining cases are missing."] {
        assert!(said.contains(words), "{said}");
    }
}

/// What an interrupted trial has is printed and written, beside the results of an earlier, whole one.
#[test]
fn an_interrupted_trial_keeps_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    write_seven(folder.path(), &third_hangs(folder.path()));
    std::fs::write(folder.path().join("trial.html"), "whole").unwrap();
    let arguments = [&WITH[..], &["--report", "trial.html", "--force"]].concat();
    interrupt_at_third(folder.path(), &arguments);
    let report = read_json(&folder.path().join("trial.json"));
    assert_eq!(report["interrupted"], true);
    assert_eq!(report["cases"], 2);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(page("trial.html"), "whole");
    assert!(page("trial.interrupted.html").contains("interrupted after 2 of 7"));
    let merged = slipstream(folder.path(), &["trial", "merge", "trial.json"]);
    assert_eq!(merged.status.code(), Some(2), "{merged:?}");
}

/// The same of a trial on a recording of one's own.
#[test]
fn an_interrupted_trial_on_a_recording_keeps_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = slipstream(folder.path(), &["run", "single", "--out", "own.mcap"]);
    assert!(recorded.status.success(), "{recorded:?}");
    write_program(folder.path(), &third_hangs(folder.path()));
    let arguments = "trial --on own.mcap --with program --json on.json --report on.html";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    interrupt_at_third(folder.path(), &arguments);
    let report = read_json(&folder.path().join("on.json"));
    assert_eq!(report["interrupted"], true);
    let page = std::fs::read_to_string(folder.path().join("on.html")).unwrap();
    assert!(page.contains("interrupted after 2 of"));
}

#[test]
fn invalid_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let labels = "[a]\nverdict = \"perhaps\"\nrobot_toml = \"a.toml\"\n";
    std::fs::write(folder.path().join("labels.toml"), labels).unwrap();
    assert_refused(
        folder.path(),
        &["--labels", "labels.toml"],
        "labels.toml:2: ",
    );
    let labels = "[a]\nverdict = \"match\"\nrobot_toml = \"a.toml\"\n";
    std::fs::write(folder.path().join("labels.toml"), labels).unwrap();
    assert_refused(
        folder.path(),
        &["--labels", "labels.toml"],
        "labels stand beside the folders",
    );
    assert_refused(
        folder.path(),
        &["--labels", "labels.toml", "--only", "b"],
        "--only b: is no case of",
    );
    assert_refused(
        folder.path(),
        &["--labels", "nowhere.toml"],
        "nowhere.toml: ",
    );
    assert_refused(
        folder.path(),
        &["--without", "gravity"],
        "--without gravity: is not an effect",
    );
}

/// An interruption while cases are made: exit code 130, and no folder.
#[test]
fn an_interruption_while_making_cases_leaves_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["trial", "--cases", "500", "--make-only", "--out", "never"];
    let mut child = command(folder.path(), &arguments).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let interrupt = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupt.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

/// As `write_program`, with seven cases.
fn write_seven(folder: &Path, answer: &str) {
    write_program(folder, answer);
    let one = std::fs::read_to_string(folder.join("labels.toml")).unwrap();
    let names = (1..=7).map(|number| format!("case-{number}"));
    let labels = names
        .clone()
        .map(|name| one.replace("[case]", &format!("[{name}]")));
    std::fs::write(folder.join("labels.toml"), labels.collect::<String>()).unwrap();
    for name in names {
        let case = folder.join(name);
        std::fs::create_dir_all(&case).unwrap();
        std::fs::copy(
            folder.join("case/recording.toml"),
            case.join("recording.toml"),
        )
        .unwrap();
    }
}

const MATCH: &str = "echo '{\"verdict\": \"match\"}' > \"$6\"";

/// Runs a command line, which must succeed.
fn done(folder: &Path, line: &str) -> String {
    let output = slipstream(folder, &line.split_whitespace().collect::<Vec<_>>());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn shards_of_labelled_cases_merge_to_the_whole_or_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_seven(folder, MATCH);
    let trial = "trial --labels labels.toml --with program";
    done(folder, &format!("{trial} --json whole.json"));
    for index in 1..=3 {
        done(
            folder,
            &format!("{trial} --shard {index}/3 --json {index}.json"),
        );
    }
    done(
        folder,
        "trial merge 3.json 1.json 2.json --json merged.json --report merged.html",
    );
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("merged.json") == read("whole.json"));
    assert_eq!(
        read_json(&folder.join("whole.json"))["each"]
            .as_array()
            .unwrap()
            .len(),
        7
    );
    assert!(read("merged.html").contains("7 cases"));

    done(
        folder,
        &format!("{trial} --shard 3/3 --json limit.json --limit-s 7"),
    );
    let cut = read("3.json");
    std::fs::write(folder.join("cut.json"), &cut[..cut.len() / 2]).unwrap();
    let mut fewer = read_json(&folder.join("3.json"));
    fewer["each"].as_array_mut().unwrap().pop();
    std::fs::write(folder.join("fewer.json"), fewer.to_string()).unwrap();
    let mut own = read_json(&folder.join("3.json"));
    own.as_object_mut().unwrap().remove("part");
    std::fs::write(folder.join("own.json"), own.to_string()).unwrap();
    std::fs::write(folder.join("no.json"), "{}\n").unwrap();
    for (third, words) in [
        (
            "",
            "FILE: shard 3/3 is missing; run it with --shard 3/3 and give its file too",
        ),
        (
            "2.json",
            "2.json: is shard 2/3 a second time; give each shard once",
        ),
        (
            "limit.json",
            "limit.json: is of another trial than 1.json; merge shards of one command line",
        ),
        ("cut.json", "cut.json:"),
        (
            "fewer.json",
            "fewer.json: shard 3/3 lacks a case; run it again",
        ),
        (
            "own.json",
            "own.json: is no shard of a trial; give files that",
        ),
        ("no.json", "no.json:1: is not a trial: missing field"),
        ("absent.json", "absent.json: cannot be read"),
    ] {
        let line = format!("merge 1.json 2.json {third} --json never.json");
        let arguments: Vec<&str> = line.split_whitespace().collect();
        assert_refused(folder, &arguments, words);
    }
    assert!(!folder.join("never.json").exists());
    assert_refused(
        folder,
        &["--cases", "3", "--shard", "1/4"],
        "--shard 1/4: there are 3 cases; give at most 3",
    );
    assert_refused(
        folder,
        &["--cases", "3", "--shard", "4"],
        "--shard 4: is not a valid shard",
    );
}

/// A shard of new cases commits itself to their labels before anything is diagnosed; the shards together make
/// what one process makes.
#[test]
fn shards_of_new_cases_are_sealed_and_merge_to_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // The program finds the commitments beside the recordings of the trial, and no label.
    let answer = format!(
        "cd {} && for out in whole 1 2; do [ -e $out ] || continue; [ -s $out/commitments.txt ] || exit 4; \
         [ -e $out/done ] || [ ! -e $out/labels.toml ] || exit 5; done; \
         cd \"$OLDPWD\"; echo '{{\"verdict\": \"match\"}}' > \"$6\"",
        folder.display()
    );
    write_program(folder, &answer);
    let trial = "trial --cases 3 --seed 5 --with program";
    for (shard, out) in [("", "whole"), ("--shard 1/2", "1"), ("--shard 2/2", "2")] {
        done(
            folder,
            &format!("{trial} {shard} --out {out} --json {out}.json"),
        );
        std::fs::write(folder.join(out).join("done"), "").unwrap();
    }
    done(folder, "trial merge 1.json 2.json --json merged.json");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(read("merged.json") == read("whole.json"));
    let whole = read_json(&folder.join("whole.json"));
    assert_eq!(whole["failed"], 0, "{whole}");
    assert_eq!(whole["commitments"].as_array().unwrap().len(), 3);
    let [one, two] = ["1", "2"].map(|name| files(&folder.join(name)));
    let whole = files(&folder.join("whole"));
    assert!(!one.contains_key("case-0002/recording.toml"));
    for (name, bytes) in &whole {
        if name.starts_with("case") || name.starts_with("sealed") || name.starts_with("robots") {
            assert!(one.get(name).or(two.get(name)) == Some(bytes), "{name}");
        }
    }
    let commitments = |files: &BTreeMap<String, Vec<u8>>| {
        let text = String::from_utf8(files["commitments.txt"].clone()).unwrap();
        text.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let mut both = [commitments(&one), commitments(&two)].concat();
    both.sort_by_key(|line| line.split_once("  ").unwrap().1.to_owned());
    assert_eq!(both, commitments(&whole));
}

#[test]
fn a_shard_that_is_there_is_not_diagnosed_again() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_seven(folder, MATCH);
    let trial = "trial --labels labels.toml --with program --resume --json a.json";
    done(folder, &format!("{trial} --shard 1/3"));
    let first = std::fs::read(folder.join("a.json")).unwrap();
    write_seven(folder, "exit 1");
    done(folder, &format!("{trial} --shard 1/3 --report a.html"));
    assert!(std::fs::read(folder.join("a.json")).unwrap() == first);
    assert!(folder.join("a.html").exists());
    // Another shard is.
    done(folder, &format!("{trial} --shard 2/3"));
    assert_eq!(read_json(&folder.join("a.json"))["failed"], 2);
}

#[test]
fn a_dry_run_prints_costs_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_seven(folder, MATCH);
    let before = files(folder);
    let text = done(
        folder,
        "trial --labels labels.toml --with program --dry-run --json t.json --report t.html --shard 2/3",
    );
    assert!(files(folder) == before);
    assert!(text.starts_with("7 cases\nAbout 0.000"), "{text}");
    assert!(text.contains("an estimate from 7 of the cases"), "{text}");
    let line = text.lines().last().unwrap();
    assert_eq!(
        line,
        "slipstream trial --labels labels.toml --with program --shard 1/1 --json shard-1.json"
    );
    done(folder, line.strip_prefix("slipstream ").unwrap());
    assert_refused(folder, &["--cases", "1", "--on", "x", "--dry-run"], "");
}
