//! `slipstream diagnose` on the command line: the example of the README, and recordings with faults
//! that could be mistaken for physics.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::{Path, PathBuf};

use common::{read_json, slipstream};
use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Copies a folder with all that is in it.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).unwrap();
        }
    }
}

/// A copy of tests/example in a new folder: recording and model.
fn example() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy(&root().join("tests/example"), folder.path());
    folder
}

/// Splits a text into its words and its numbers.
fn words_and_numbers(text: &str) -> (Vec<String>, Vec<f64>) {
    let trimmed = |word: &str| word.trim_matches(['(', ')', '.', ',', ';']).to_owned();
    let (numbers, words): (Vec<String>, Vec<String>) = text
        .split_whitespace()
        .map(trimmed)
        .partition(|word| word.parse::<f64>().is_ok());
    let numbers = numbers.iter().map(|word| word.parse().unwrap());
    (words, numbers.collect())
}

/// Runs the commands of a document in a folder, in their order, and compares what they print with what stands below them:
/// the same words, and about the same numbers. Returns the number of commands.
fn follow(document: &str, folder: &Path) -> usize {
    let text = std::fs::read_to_string(root().join(document)).unwrap();
    let mut commands = 0;
    let blocks = text.split("```console\n").skip(1);
    for block in blocks.map(|block| block.split("```").next().unwrap()) {
        for part in block.split("$ slipstream ").skip(1) {
            let (command, expected) = part.split_once('\n').unwrap();
            let arguments: Vec<&str> = command.split(' ').collect();
            let output = slipstream(folder, &arguments);
            assert!(output.status.success(), "{command}");
            let stdout = String::from_utf8(output.stdout).unwrap();
            let (words, numbers) = words_and_numbers(&stdout);
            let (expected_words, expected_numbers) = words_and_numbers(expected);
            assert_eq!(words, expected_words, "{document}: {command}");
            for (number, expected) in numbers.iter().zip(&expected_numbers) {
                let is_close = (number - expected).abs() <= 0.05 * expected.abs() + 2e-4;
                assert!(
                    is_close,
                    "{document}: {command}: {number} instead of {expected}"
                );
            }
            commands += 1;
        }
    }
    commands
}

#[test]
fn readme_example_matches_the_output() {
    assert_eq!(follow("README.md", example().path()), 4);
}

#[test]
fn the_tutorial_can_be_followed_word_by_word() {
    let folder = tempfile::tempdir().unwrap();
    copy(&root().join("examples/cart"), folder.path());
    assert_eq!(follow("docs/tutorial.md", folder.path()), 5);
}

type Row = Vec<String>;

/// Changes the rows of a file of the recording.
fn modify(folder: &Path, file: &str, change: impl Fn(Vec<Row>) -> Vec<Row>) {
    let path = folder.join("recording/r1").join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let split = |line: &str| line.split(',').map(str::to_owned).collect();
    let rows = change(rows.lines().map(split).collect());
    let rows: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(path, format!("{header}\n{}\n", rows.join("\n"))).unwrap();
}

/// Swaps the columns of the right and left wheel.
fn swapped(mut rows: Vec<Row>) -> Vec<Row> {
    rows.iter_mut().for_each(|row| row.swap(1, 2));
    rows
}

/// Multiplies these columns of all rows by a factor.
fn scaled(columns: &'static [usize], factor: f64) -> impl Fn(Vec<Row>) -> Vec<Row> {
    move |mut rows| {
        for row in &mut rows {
            for column in columns {
                let value: f64 = row[*column].parse().unwrap();
                row[*column] = (value * factor).to_string();
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

/// Changes a file of the example and expects a one-line error that contains `expected`.
fn assert_refused(file: &str, change: impl Fn(Vec<Row>) -> Vec<Row>, expected: &str) {
    let folder = example();
    modify(folder.path(), file, change);
    let output = slipstream(folder.path(), &ARGUMENTS);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{expected}: {stderr}");
    assert_eq!(stderr.trim_end().lines().count(), 1, "{stderr}");
    let is_complete = stderr.contains("practice-04: r1: ") && stderr.contains(expected);
    assert!(
        is_complete && stderr.contains("; "),
        "no {expected:?} in {stderr}"
    );
    assert!(!folder.path().join("answer.json").exists());
}

#[test]
fn swapped_and_reversed_streams_are_refused() {
    assert_refused("wheels.csv", swapped, "right and left wheel are swapped");
    assert_refused("wheels.csv", scaled(&[1, 2], -1.0), "count backwards");
    assert_refused(
        "wheels.csv",
        scaled(&[2], -1.0),
        "left wheel counts backwards",
    );
    assert_refused("command.csv", swapped, "follows the other one's command");
    assert_refused(
        "command.csv",
        scaled(&[1, 2], -1.0),
        "speed up against their commands",
    );
}

#[test]
fn wrong_units_are_refused() {
    let degrees = 1_f64.to_degrees();
    assert_refused("pose.csv", scaled(&[3], degrees), "in degrees");
    assert_refused("pose.csv", scaled(&[1, 2], 1e3), "in mm");
    assert_refused("command.csv", scaled(&[1, 2], 1e3), "in mN m");
    assert_refused("pose.csv", scaled(&[0], 1e3), "milliseconds");
}

#[test]
fn a_gap_is_a_warning_and_no_finding() {
    let folder = example();
    modify(folder.path(), "wheels.csv", |mut rows| {
        rows.retain(|row| !(10.0..14.0).contains(&row[0].parse().unwrap()));
        rows
    });
    let output = slipstream(folder.path(), &ARGUMENTS);
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{stdout}");
    assert!(
        stdout.contains("Warning: practice-04, r1: wheels pauses once"),
        "{stdout}"
    );
    let answer = read_json(&folder.path().join("answer.json"));
    assert_eq!(answer["warnings"][0]["id"], "gaps");
    assert_eq!(answer["verdict"], "explained");
    assert_eq!(answer["findings"][0]["effect"], "rolling_resistance");
    assert_eq!(answer["findings"].as_array().unwrap().len(), 1);
}

/// A recording of a network alone holds nothing that could match.
#[test]
fn a_recording_without_robots_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let network = folder.path().join("network");
    std::fs::create_dir(&network).unwrap();
    let about = "format = 1\nname = \"network\"\norigin = \"test\"\n";
    std::fs::write(network.join("recording.toml"), about).unwrap();
    std::fs::write(network.join("rtt.csv"), "seq,rtt_ms\n0,1.5\n1,1.7\n").unwrap();
    let output = slipstream(folder.path(), &["diagnose", "network"]);
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        stderr.contains("network: holds no robot to diagnose"),
        "{stderr}"
    );
}

/// Radii (right, left), half track and place of the camera of a robot whose model has 0.05, 0.05, 0.12 and none (m).
const RADII_M: [f64; 2] = [0.048, 0.049];
const HALF_TRACK_M: f64 = 0.126;
const CAMERA_M: [f64; 2] = [0.1, 0.02];

/// Forty seconds of a robot without commands: wheels at 50 Hz, poses of its camera at 20 Hz with 2 mm and 4 mrad.
fn driven(folder: &Path) {
    let noise = |k: f64| 2.0 * ((k * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 1.0;
    let mut wheels = "t_s,angle_right_rad,angle_left_rad\n".to_owned();
    let mut poses = "t_s,x_m,y_m,yaw_rad\n".to_owned();
    let (mut angles, [mut x, mut y, mut yaw]) = ([0.0_f64; 2], [0.0, 0.0, 0.2_f64]);
    for k in 0..40_000_u32 {
        let t_s = f64::from(k) * 1e-3;
        let (sin, cos) = yaw.sin_cos();
        if k % 20 == 0 {
            wheels += &format!("{t_s:.3},{:.9},{:.9}\n", angles[0], angles[1]);
        }
        if k % 50 == 0 {
            let [along, across, turn] = [0.0, 0.3, 0.7].map(|part| noise(f64::from(k) + part));
            let at = [
                x + CAMERA_M[0] * cos - CAMERA_M[1] * sin,
                y + CAMERA_M[0] * sin + CAMERA_M[1] * cos,
            ];
            poses += &format!(
                "{t_s:.3},{:.6},{:.6},{:.6}\n",
                at[0] + 2e-3 * along,
                at[1] + 2e-3 * across,
                yaw + 4e-3 * turn
            );
        }
        let v = 0.3 + 0.15 * (0.9 * t_s).sin();
        let w = 0.8 * (0.5 * t_s).sin() + 0.3 * (2.7 * t_s).cos();
        let rims = [v + HALF_TRACK_M * w, v - HALF_TRACK_M * w];
        angles = [0, 1].map(|i| angles[i] + 1e-3 * rims[i] / RADII_M[i]);
        let middle = yaw + 0.5e-3 * w;
        (x, y, yaw) = (
            x + 1e-3 * v * middle.cos(),
            y + 1e-3 * v * middle.sin(),
            yaw + 1e-3 * w,
        );
    }
    std::fs::create_dir_all(folder.join("recording/r1")).unwrap();
    std::fs::write(folder.join("recording/r1/wheels.csv"), wheels).unwrap();
    std::fs::write(folder.join("recording/r1/pose.csv"), poses).unwrap();
    let recording = "format = 1\nname = \"driven\"\n[robots.r1]\npose_point = \"axle\"\n";
    std::fs::write(folder.join("recording/recording.toml"), recording).unwrap();
    let model = "format = 1\n[robot]\nwheel_radius_m = 0.05\nhalf_track_m = 0.12\n";
    std::fs::write(folder.join("robot.toml"), model).unwrap();
}

/// What stands behind `key` in a text, as a number.
fn number_behind(text: &str, key: &str) -> f64 {
    let rest = text
        .split_once(key)
        .unwrap_or_else(|| panic!("{key}: {text}"))
        .1;
    let word = rest.split_whitespace().next().unwrap();
    word.parse().unwrap()
}

#[test]
fn a_calibration_has_the_truth_as_parameters_of_the_controller() {
    let folder = tempfile::tempdir().unwrap();
    driven(folder.path());
    let command =
        "diagnose recording --robot robot.toml --calibration controller.yaml --json answer.json";
    let arguments: Vec<&str> = command.split(' ').collect();
    let output = slipstream(folder.path(), &arguments);
    assert!(output.status.success(), "{output:?}");
    let text = std::fs::read_to_string(folder.path().join("controller.yaml")).unwrap();
    assert!(
        text.contains("\ndiff_drive_controller:\n  ros__parameters:\n    wheel_separation: 0.24\n")
    );
    for (key, truth, tolerance) in [
        ("wheel_radius: ", 0.05, 0.0),
        ("wheel_separation_multiplier: ", 1.05, 3e-3),
        ("right_wheel_radius_multiplier: ", 0.96, 1e-3),
        ("left_wheel_radius_multiplier: ", 0.98, 1e-3),
        ("--x ", 0.1, 2e-3),
        ("--y ", 0.02, 2e-3),
    ] {
        let number = number_behind(&text, key);
        assert!((number - truth).abs() <= tolerance, "{key}{number}");
    }
    let answer = read_json(&folder.path().join("answer.json"));
    let stdout = String::from_utf8(output.stdout).unwrap();
    for finding in answer["findings"].as_array().unwrap() {
        let action = finding["actions"][0].as_str().unwrap();
        assert!(stdout.contains(action), "{action}");
    }
    // an experiment that tells look-alikes apart is an action
    assert!(stdout.contains("- record this to tell it from "));
    // This folder is of no robot of ROS, which would be told the multiplier.
    let left_m = number_behind(&stdout, "- use wheel radii of ");
    assert!((left_m - 0.98 * 0.05).abs() <= 1e-4, "{left_m}");
}

#[test]
fn a_calibration_that_cannot_be_written_is_refused() {
    let folder = example();
    let command = "diagnose recording --robot robot.toml --calibration nowhere/controller.yaml";
    let arguments: Vec<&str> = command.split(' ').collect();
    let output = slipstream(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("nowhere/controller.yaml"), "{stderr}");
}
