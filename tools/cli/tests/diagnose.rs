//! `slipstream diagnose` as a user meets it: the walk-through of the README, and recordings with
//! faults that pose as physics.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use std::path::{Path, PathBuf};

use common::{read_json, slipstream};
use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A copy of the example: recording and model.
fn example() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let from = root().join("tests/example");
    std::fs::create_dir_all(folder.path().join("recording/r1")).unwrap();
    for file in [
        "robot.toml",
        "recording/recording.toml",
        "recording/r1/command.csv",
        "recording/r1/pose.csv",
        "recording/r1/wheels.csv",
    ] {
        std::fs::copy(from.join(file), folder.path().join(file)).unwrap();
    }
    folder
}

/// Words, and numbers apart from them.
fn parts(text: &str) -> (Vec<String>, Vec<f64>) {
    let trimmed = |word: &str| word.trim_matches(['(', ')', '.', ',', ';']).to_owned();
    let (numbers, words): (Vec<String>, Vec<String>) = text
        .split_whitespace()
        .map(trimmed)
        .partition(|word| word.parse::<f64>().is_ok());
    let numbers = numbers.iter().map(|word| word.parse().unwrap());
    (words, numbers.collect())
}

#[test]
fn the_walk_through_of_the_readme_is_what_the_program_says() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let block = readme.split("```console\n").nth(1).unwrap();
    let block = block.split("```").next().unwrap();
    let folder = example();
    let mut commands = 0;
    for part in block.split("$ slipstream ").skip(1) {
        let (command, wanted) = part.split_once('\n').unwrap();
        let arguments: Vec<&str> = command.split(' ').collect();
        let output = slipstream(folder.path(), &arguments);
        assert!(output.status.success(), "{command}");
        let said = String::from_utf8(output.stdout).unwrap();
        let (words, numbers) = parts(&said);
        let (wanted_words, wanted_numbers) = parts(wanted);
        assert_eq!(words, wanted_words, "{command}");
        for (number, wanted) in numbers.iter().zip(&wanted_numbers) {
            let near = (number - wanted).abs() <= 0.05 * wanted.abs() + 2e-4;
            assert!(near, "{command}: {number} where README.md has {wanted}");
        }
        commands += 1;
    }
    assert_eq!(commands, 4);
}

type Row = Vec<String>;

/// Rewrites the rows of a file of the recording.
fn spoil(folder: &Path, file: &str, change: impl Fn(Vec<Row>) -> Vec<Row>) {
    let path = folder.join("recording/r1").join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let split = |line: &str| line.split(',').map(str::to_owned).collect();
    let rows = change(rows.lines().map(split).collect());
    let rows: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(path, format!("{head}\n{}\n", rows.join("\n"))).unwrap();
}

fn swapped(mut rows: Vec<Row>) -> Vec<Row> {
    rows.iter_mut().for_each(|row| row.swap(1, 2));
    rows
}

/// The rows with these columns multiplied.
fn scaled(columns: &'static [usize], by: f64) -> impl Fn(Vec<Row>) -> Vec<Row> {
    move |mut rows| {
        for row in &mut rows {
            for column in columns {
                let value: f64 = row[*column].parse().unwrap();
                row[*column] = (value * by).to_string();
            }
        }
        rows
    }
}

const ARGUMENTS: [&str; 6] = [
    "diagnose",
    "recording",
    "--robot",
    "robot.toml",
    "--json",
    "answer.json",
];

/// Spoils the example and expects that it is refused in one line with these words.
fn refused(file: &str, change: impl Fn(Vec<Row>) -> Vec<Row>, wanted: &str) {
    let folder = example();
    spoil(folder.path(), file, change);
    let output = slipstream(folder.path(), &ARGUMENTS);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{wanted}: {words}");
    assert_eq!(words.trim_end().lines().count(), 1, "{words}");
    let named = words.contains("practice-04: r1: ") && words.contains(wanted);
    assert!(named && words.contains("; "), "no {wanted:?} in {words}");
    assert!(!folder.path().join("answer.json").exists());
}

#[test]
fn swapped_and_reversed_streams_are_refused() {
    refused("wheels.csv", swapped, "right and left wheel are swapped");
    refused("wheels.csv", scaled(&[1, 2], -1.0), "count backwards");
    refused(
        "wheels.csv",
        scaled(&[2], -1.0),
        "left wheel counts backwards",
    );
    refused("command.csv", swapped, "follows the other one's command");
    refused(
        "command.csv",
        scaled(&[1, 2], -1.0),
        "speed up against their commands",
    );
}

#[test]
fn wrong_units_are_refused() {
    let degrees = 1_f64.to_degrees();
    refused("pose.csv", scaled(&[3], degrees), "in degrees");
    refused("pose.csv", scaled(&[1, 2], 1e3), "in mm");
    refused("command.csv", scaled(&[1, 2], 1e3), "in mN m");
    refused("pose.csv", scaled(&[0], 1e3), "milliseconds");
}

#[test]
fn a_pause_is_said_and_does_not_pose_as_physics() {
    let folder = example();
    spoil(folder.path(), "wheels.csv", |mut rows| {
        rows.retain(|row| !(10.0..14.0).contains(&row[0].parse().unwrap()));
        rows
    });
    let output = slipstream(folder.path(), &ARGUMENTS);
    let words = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{words}");
    assert!(
        words.contains("Warning: practice-04, r1: wheels pauses 1 times"),
        "{words}"
    );
    let answer = read_json(&folder.path().join("answer.json"));
    assert_eq!(answer["warnings"][0]["id"], "gaps");
    assert_eq!(answer["verdict"], "explained");
    assert_eq!(answer["findings"][0]["effect"], "rolling_resistance");
    assert_eq!(answer["findings"].as_array().unwrap().len(), 1);
}
