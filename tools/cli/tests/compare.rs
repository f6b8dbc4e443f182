//! `slipstream compare REAL SIMULATED`: what was put into one of two runs is what differs.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::schemas::violations;
use common::{read_json, slipstream};
use serde_json::Value;

/// Records six seconds of the platoon.
fn run(folder: &Path, out: &str, more: &[&str]) {
    let arguments = ["run", "platoon", "--set", "duration_s=6", "--out", out];
    succeeds(folder, &[&arguments[..], more].concat());
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = slipstream(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What is printed, and the answer, which conforms to its schema.
fn compared(folder: &Path, recordings: [&str; 2]) -> (String, Value) {
    let [real, simulated] = recordings;
    let arguments = ["compare", real, simulated, "--json", "answer.json"];
    let text = succeeds(folder, &arguments);
    let answer = read_json(&folder.join("answer.json"));
    assert_eq!(violations("compare", &answer), [""; 0]);
    (text, answer)
}

fn number(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("{path} of {value}"))
}

#[test]
fn two_runs_of_one_seed_are_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "a.mcap", &[]);
    run(folder, "b.mcap", &[]);
    let (text, answer) = compared(folder, ["a.mcap", "b.mcap"]);
    assert!(text.starts_with("Both recordings agree: "), "{text}");
    assert!(text.contains("Try: slipstream diagnose a.mcap\n"), "{text}");
    for robot in answer["robots"].as_array().unwrap() {
        assert_eq!(number(robot, "/path/largest_m"), 0.0);
        assert_eq!(number(robot, "/slip/difference_percent"), 0.0);
        if robot["robot"] != "r1" {
            assert_eq!(number(robot, "/spacing/rms_difference_m"), 0.0);
            assert_eq!(number(robot, "/spacing/largest_difference_m"), 0.0);
        }
    }
    assert!(answer["robots"][0]["spacing"].is_null());
    let links = answer["links"].as_array().unwrap();
    assert_eq!(links.len(), 3);
    for stage in links
        .iter()
        .flat_map(|link| link["stages"].as_array().unwrap())
    {
        assert_eq!(stage["real"], stage["simulated"]);
        assert_eq!(stage["changed"], false);
    }
}

/// The spacing from poses is that which the plant measures: they have noise of 2 mm, and ten of them are smoothed, so that the
/// distance of two robots has 0.9 mm; 3 mm are more than three times that.
#[test]
fn the_spacing_is_that_of_the_plant() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(folder, &["run", "--out", "a.mcap", "--json", "a.json"]);
    let (_, answer) = compared(folder, ["a.mcap", "a.mcap"]);
    let summary = read_json(&folder.join("a.json"));
    for robot in 1..3 {
        let plant_m = number(&summary, &format!("/robots/{robot}/max_spacing_error_m"));
        let by_poses_m = number(&answer, &format!("/robots/{robot}/spacing/real/largest_m"));
        assert!(
            (plant_m - by_poses_m).abs() < 0.003,
            "{plant_m} {by_poses_m}"
        );
    }
}

#[test]
fn a_delay_of_the_links_is_in_the_stage_and_in_the_spacing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "late.mcap", &["--set", "links.delay_s=0.1"]);
    run(folder, "a.mcap", &[]);
    let (text, answer) = compared(folder, ["late.mcap", "a.mcap"]);
    for link in answer["links"].as_array().unwrap() {
        let stages = link["stages"].as_array().unwrap();
        let delay = stages
            .iter()
            .find(|own| own["stage"] == "injected_delay")
            .unwrap();
        assert!((number(delay, "/real/p50_s") - 0.1).abs() < 1e-6);
        assert_eq!(number(delay, "/simulated/p95_s"), 0.0);
        assert_eq!(delay["changed"], true);
    }
    // The front robot follows nobody; the others are later than before.
    assert_eq!(number(&answer, "/robots/0/path/largest_m"), 0.0);
    for robot in 1..3 {
        assert!(
            number(
                &answer,
                &format!("/robots/{robot}/spacing/largest_difference_m")
            ) > 0.01
        );
    }
    assert!(text.contains("worse than simulated"), "{text}");
    assert!(
        text.contains("Try: slipstream trace late.mcap --against a.mcap\n"),
        "{text}"
    );
}

/// Wheels of r1 that are 3 % larger than its model says: it moves further than its wheels seem to roll.
#[test]
fn a_wheel_radius_is_in_the_slip_of_its_robot_alone() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "a.mcap", &[]);
    succeeds(folder, &["export", "a.mcap", "--out", "folder"]);
    let model = std::fs::read_to_string(folder.join("folder/robot.toml")).unwrap();
    let effect = "\n[effects]\nwheel_radius = { right_scale = 1.03, left_scale = 1.03 }\n";
    std::fs::write(folder.join("large.toml"), model.clone() + effect).unwrap();
    std::fs::write(folder.join("robot.toml"), model).unwrap();
    run(folder, "b.mcap", &["--robot", "robot.toml"]);
    run(
        folder,
        "large.mcap",
        &["--robot", "robot.toml", "--robot", "r1=large.toml"],
    );
    let (_, answer) = compared(folder, ["large.mcap", "b.mcap"]);
    let percent =
        |robot: usize| number(&answer, &format!("/robots/{robot}/slip/difference_percent"));
    assert!((percent(0) + 3.0).abs() < 0.5, "{}", percent(0));
    for robot in 1..3 {
        assert!(percent(robot).abs() < 0.5, "{}", percent(robot));
    }
    assert!(number(&answer, "/robots/0/path/largest_m") > 0.02);
}

/// A recording of real robots: a folder without trace and experiment, wheels as angles, robots told twists, one without poses.
#[test]
fn a_folder_of_a_real_run_is_compared_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "a.mcap", &[]);
    succeeds(folder, &["export", "a.mcap", "--out", "real"]);
    for robot in ["r1", "r2", "r3"] {
        let own = folder.join("real").join(robot);
        std::fs::write(
            own.join("command.csv"),
            "t_s,v_m_s,w_rad_s\n0,0,0\n0.1,0.2,0\n",
        )
        .unwrap();
        let wheels = std::fs::read_to_string(own.join("wheels.csv")).unwrap();
        let angles = wheels.lines().skip(1).map(|line| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let [right, left] =
                [cells[1], cells[2]].map(|ticks| ticks * std::f64::consts::TAU / 1856.0);
            format!("{},{right},{left}\n", cells[0])
        });
        let angles: String = angles.collect();
        let head = "t_s,angle_right_rad,angle_left_rad\n";
        std::fs::write(own.join("wheels.csv"), head.to_owned() + &angles).unwrap();
    }
    std::fs::remove_file(folder.join("real/r3/pose.csv")).unwrap();
    let (text, answer) = compared(folder, ["real", "a.mcap"]);
    assert!(number(&answer, "/robots/1/path/largest_m") < 1e-9);
    assert!(number(&answer, "/robots/1/spacing/largest_difference_m").abs() < 1e-9);
    assert!(number(&answer, "/robots/1/slip/difference_percent").abs() < 1e-6);
    let blind = &answer["robots"][2];
    assert!(blind["path"].is_null() && blind["spacing"]["real"].is_null());
    assert!(blind["slip"]["real"].is_null() && blind["slip"]["simulated"].is_object());
    assert_eq!(answer["links"].as_array().unwrap().len(), 0);
    assert!(
        text.contains("  r3                                  -"),
        "{text}"
    );
}

#[test]
fn recordings_of_different_robots_or_times_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "a.mcap", &[]);
    for (name, robot, time_s) in [("other", "cart", 0.0), ("late", "r1", 100.0)] {
        let own = folder.join(name);
        std::fs::create_dir_all(own.join(robot)).unwrap();
        std::fs::write(
            own.join("recording.toml"),
            format!("format = 1\n[robots.{robot}]\n"),
        )
        .unwrap();
        let rows = format!("t_s,x_m,y_m\n{time_s},0,0\n{},1,0\n", time_s + 5.0);
        std::fs::write(own.join(robot).join("pose.csv"), rows).unwrap();
    }
    for (real, problem) in [
        (
            "other",
            "other and a.mcap: have no robot in common: cart, and r1, r2, r3; give recordings",
        ),
        (
            "late",
            "late and a.mcap: do not overlap in time: 100.00 to 105.00 s, and 0.00 to 6.00 s; give recordings",
        ),
    ] {
        let output = slipstream(folder, &["compare", real, "a.mcap"]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(
            stderr.starts_with(&format!("slipstream: {problem}")),
            "{stderr}"
        );
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
    let output = slipstream(folder, &["compare", "a.mcap", "--json", "x.json"]);
    assert_eq!(output.status.code(), Some(2));
}
