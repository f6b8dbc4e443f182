//! The scripts for clusters in `examples`: a shell reads them, and their command lines are those of the program. The test
//! sets Slurm's variables; programs of its own stand for GNU parallel and, where a shard would take long, for slipstream.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use common::{read_json, slipstream};

const SCRIPTS: [&str; 5] = [
    "study-delay.sbatch",
    "trial.sbatch",
    "merge.sbatch",
    "study-delay.parallel.sh",
    "trial.parallel.sh",
];

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples")
        .join(name)
}

/// A folder with the programs that a script finds before those of the machine.
fn programs(folder: &Path, programs: &[(&str, &str)]) -> PathBuf {
    let place = folder.join("bin");
    std::fs::create_dir(&place).unwrap();
    for (name, text) in programs {
        let file = place.join(name);
        std::fs::write(&file, format!("#!/bin/bash\n{text}\n")).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    place
}

/// Runs a script in a folder with these programs and variables.
fn script(
    folder: &Path,
    programs: &Path,
    name: &str,
    arguments: &[&str],
    variables: &[(&str, &str)],
) -> Output {
    let path = std::env::var("PATH").unwrap();
    let mut bash = Command::new("bash");
    bash.arg(example(name))
        .args(arguments)
        .current_dir(folder)
        .env("PATH", format!("{}:{path}", programs.display()))
        .env("SLURM_CPUS_PER_TASK", "2")
        .env("SLURM_ARRAY_TASK_COUNT", "1")
        .envs(variables.iter().copied());
    bash.output().unwrap()
}

#[test]
fn a_shell_reads_every_script() {
    for name in SCRIPTS {
        let read = Command::new("bash").arg("-n").arg(example(name)).status();
        assert!(read.unwrap().success(), "{name}");
        let text = std::fs::read_to_string(example(name)).unwrap();
        let lines = text.lines().skip(1);
        let head = lines.take_while(|line| line.is_empty() || line.starts_with('#'));
        let directives = head.filter(|line| line.starts_with("#SBATCH --")).count();
        let expected = match name {
            "merge.sbatch" => 3,
            _ if name.ends_with(".sbatch") => 6,
            _ => 0,
        };
        assert_eq!(directives, expected, "{name}");
        // N of the script and of its array.
        let number = |start: &str| {
            let rest = text.split(start).nth(1)?;
            rest.split(|c: char| !c.is_ascii_digit()).next()
        };
        if let Some(array) = number("--array=1-") {
            assert_eq!(number("${SHARDS:-"), Some(array), "{name}");
        }
    }
}

/// The array is as long as the study has points, so that each job has one; N is not Slurm's count.
#[test]
fn the_array_of_a_study_computes_a_shard_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let slipstream_program = format!("exec {} \"$@\"", env!("CARGO_BIN_EXE_slipstream"));
    let programs = programs(folder, &[("slipstream", &slipstream_program)]);
    let job = |task: &str| {
        let variables = [("SLURM_ARRAY_TASK_ID", task), ("SHARDS", "5632")];
        let output = script(folder, &programs, "study-delay.sbatch", &[], &variables);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), stderr)
    };
    assert_eq!(job("2"), (Some(0), String::new()));
    let file = folder.join("shard-2.json");
    let shard = read_json(&file);
    assert_eq!(shard["shard"], serde_json::json!({"index": 2, "of": 5632}));
    assert_eq!(shard["points"].as_array().unwrap().len(), 1);
    assert_eq!(shard["points"][0]["runs"], 100);
    // Again: what is there is kept, unless it was interrupted.
    let text = std::fs::read_to_string(&file).unwrap();
    let marked = text.replace("\"loss\": 0.0,", "\"loss\": 0.25,");
    assert_ne!(text, marked);
    std::fs::write(&file, &marked).unwrap();
    assert_eq!(job("2").0, Some(0));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), marked);
    let interrupted = marked.trim_end().strip_suffix('}').unwrap().trim_end();
    std::fs::write(
        &file,
        format!("{interrupted},\n  \"interrupted\": true\n}}\n"),
    )
    .unwrap();
    assert_eq!(job("2").0, Some(0));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    let merge = script(folder, &programs, "merge.sbatch", &["study"], &[]);
    let stderr = String::from_utf8_lossy(&merge.stderr).into_owned();
    assert_eq!(merge.status.code(), Some(2), "{stderr}");
    let words = "shards 1,3,4,5,6,7,8,9,… of 5632 are missing";
    assert!(stderr.contains(words), "{stderr}");
    assert!(!folder.join("study.json").exists());
    let (code, stderr) = job("5633");
    assert_eq!(code, Some(2), "{stderr}");
}

/// A program in the place of slipstream that writes down how it was called, one word a line.
const WRITES_DOWN: &str = r#"printf '%s\n' "$@" END >> calls.txt"#;
/// A program in the place of GNU parallel: one job after the other, as `parallel COMMAND ::: VALUES` runs them.
const PARALLEL: &str = r#"
while [ "$1" != slipstream ]; do printf '%s\n' "$1" >> options.txt; shift; done
command=()
while [ "$1" != ::: ]; do command+=("$1"); shift; done
shift
for value; do "${command[@]//\{\}/$value}" || exit; done"#;

/// The calls that a script makes.
fn calls(folder: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("calls.txt")).unwrap();
    let calls = text.split("END\n").filter(|call| !call.is_empty());
    calls
        .map(|call| call.lines().map(str::to_owned).collect())
        .collect()
}

/// Gives the program the calls of each script, with a shard that does not exist: all that comes before is accepted.
#[test]
fn every_command_line_of_the_scripts_is_one_of_the_program() {
    for (name, arguments) in [
        ("study-delay.sbatch", &[][..]),
        ("trial.sbatch", &[]),
        ("merge.sbatch", &["study"]),
        ("merge.sbatch", &["trial"]),
        ("study-delay.parallel.sh", &["--sshloginfile", "hosts.txt"]),
        ("trial.parallel.sh", &[]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let programs = programs(
            folder,
            &[("slipstream", WRITES_DOWN), ("parallel", PARALLEL)],
        );
        for file in ["shard-1.json", "shard-12.json", "shard-1.interrupted.json"] {
            std::fs::write(folder.join(file), "").unwrap();
        }
        let variables = [("SLURM_ARRAY_TASK_ID", "7")];
        let output = script(folder, &programs, name, arguments, &variables);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {stderr}");
        let calls = calls(folder);
        let parallel = name.ends_with(".parallel.sh");
        let shards = 8;
        assert_eq!(calls.len(), if parallel { shards + 1 } else { 1 }, "{name}");
        if parallel {
            let options = std::fs::read_to_string(folder.join("options.txt")).unwrap();
            let log = "--joblog\nshards.log\n--resume-failed\n";
            assert!(options.starts_with(log), "{name}: {options}");
            assert!(options.contains(&arguments.join("\n")), "{name}: {options}");
        }
        for (number, call) in (1..).zip(&calls) {
            let mut words: Vec<&str> = call.iter().map(String::as_str).collect();
            let expected = if words[1] == "merge" {
                assert_eq!(words[2..4], ["shard-1.json", "shard-12.json"], "{name}");
                "shard-1.json:1: is not a"
            } else {
                let task = if parallel { number } else { 7 };
                let shard = words.iter().position(|word| *word == "--shard").unwrap() + 1;
                assert_eq!(words[shard], format!("{task}/{shards}"), "{name}");
                assert!(words.contains(&format!("shard-{task}.json").as_str()));
                words[shard] = "1/999999";
                "--shard 1/999999: there are"
            };
            let output = slipstream(folder, &words);
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{name}: {stderr}");
            assert!(stderr.contains(expected), "{name}: {stderr}");
        }
    }
}
