//! Commands on recordings (import, export, check, compare): output files and exit codes.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::process::{Command, Output};

/// Runs `slipstream` in a folder.
fn slipstream(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_slipstream"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// Exit code and text on standard error.
fn code_and_stderr(output: &Output) -> (Option<i32>, String) {
    (
        output.status.code(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

fn write_recording(folder: &Path) {
    let files = [
        (
            "recording.toml",
            "format = 1\nname = \"n\"\n[robots.r1]\nencoder_counts_per_rev = 1856\n",
        ),
        (
            "robot.toml",
            "format = 1\n[robot]\nwheel_radius_m = 0.0365\nhalf_track_m = 0.105\n",
        ),
        (
            "r1/command.csv",
            "t_s,v_m_s,w_rad_s\n0,0.1,0\n0.5,0.1,0.2\n1,0,0\n",
        ),
        (
            "r1/wheels.csv",
            "t_s,ticks_right,ticks_left\n0,5,-3\n0.5,405,397\n1,805,797\n",
        ),
        (
            "r1/pose.csv",
            "t_s,x_m,y_m,yaw_rad\n0,0,0,0.1\n0.5,0.05,0,0.1\n1,0.1,0,0.1\n",
        ),
    ];
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

#[test]
fn import_export_round_trip_then_check_and_compare() {
    let scratch = tempfile::tempdir().unwrap();
    let here = scratch.path();
    write_recording(&here.join("given"));
    let success = (Some(0), String::new());
    let import = slipstream(here, &["import", "given", "--out", "bag.mcap"]);
    assert_eq!(code_and_stderr(&import), success);
    let export = slipstream(here, &["export", "bag.mcap", "--out", "back"]);
    assert_eq!(code_and_stderr(&export), success);
    let read = |path: &str| std::fs::read_to_string(here.join(path)).unwrap();
    for file in [
        "r1/command.csv",
        "r1/wheels.csv",
        "r1/pose.csv",
        "robot.toml",
    ] {
        assert_eq!(
            read(&format!("given/{file}")),
            read(&format!("back/{file}")),
            "{file}"
        );
    }
    let check = slipstream(here, &["check", "bag.mcap", "--json", "check.json"]);
    assert_eq!(code_and_stderr(&check), success);
    assert!(String::from_utf8_lossy(&check.stdout).contains("can be judged"));
    let json: serde_json::Value = serde_json::from_str(&read("check.json")).unwrap();
    assert_eq!(
        (&json["format"], &json["robots"][0]["robot"]),
        (&1.into(), &"r1".into())
    );
    let compare = slipstream(here, &["compare", "bag.mcap", "--report", "page.html"]);
    assert_eq!(code_and_stderr(&compare), success);
    // five channels and the distance
    assert_eq!(read("page.html").matches("class=\"fr\"").count(), 6);
}

#[test]
fn invalid_input_is_one_line_and_exit_code_2() {
    let scratch = tempfile::tempdir().unwrap();
    let here = scratch.path();
    write_recording(&here.join("given"));
    let overwrite =
        |file: &str, text: &str| std::fs::write(here.join("given").join(file), text).unwrap();
    let import = || code_and_stderr(&slipstream(here, &["import", "given", "--out", "bag.mcap"]));
    let cases = [
        (
            "t_s,v_m_s,w_rad_s\n0,1,1\n1,1,1\n0.5,1,1\n",
            "slipstream: given/r1/command.csv:4: t_s runs backwards, from 1 to 0.5; sort the rows",
        ),
        (
            "t_s,v_m_s,w_rad_s\n0,NaN,1\n",
            "slipstream: given/r1/command.csv:2: v_m_s is \"NaN\"; ",
        ),
        (
            "t_s,v_m_s,w_rad_s\n0,1,1\n1,1,-1e300\n",
            "slipstream: given/r1/command.csv:3: w_rad_s is \"-1e300\"; give at most 1e9, in the unit",
        ),
        (
            "t_s,v_m_s,w_rad_s\n1e10,1,1\n",
            "slipstream: given/r1/command.csv:2: t_s is \"1e10\"; give seconds, at most 9.2e9",
        ),
        (
            "t_s,v_m_s,w_rad_s\n0,1\n",
            "slipstream: given/r1/command.csv:2: 2 cells in a row, 3 in ",
        ),
        (
            "t_s,v_m_s,w_rad_s,torque_right_nm,torque_left_nm\n",
            "slipstream: given/r1/command.csv:1: two command column sets, torque_right_nm,torque_",
        ),
        (
            "t_s,v_m_s\n",
            "slipstream: given/r1/command.csv:1: column w_rad_s is missing; give t_s",
        ),
        (
            "",
            "slipstream: given/r1/command.csv:1: the file is empty; ",
        ),
        (
            "time,v_m_s,w_rad_s\n",
            "slipstream: given/r1/command.csv:1: the first column is not t_s",
        ),
        (
            "t_s,v_m_s,w_rad_s\n,1,1\n",
            "slipstream: given/r1/command.csv:2: t_s is empty; ",
        ),
    ];
    for (text, message) in cases {
        overwrite("r1/command.csv", text);
        let (code, stderr) = import();
        assert_eq!(code, Some(2), "{stderr}");
        assert!(stderr.starts_with(message), "{stderr}\n expected {message}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
    for arguments in [
        &["check", "nowhere"][..],
        &["check", "."],
        &["check", "given/recording.toml"],
        &["compare", "given", "--robot", "nowhere.toml"],
        &["export", "given", "--out", "given"],
    ] {
        let (code, stderr) = code_and_stderr(&slipstream(here, arguments));
        assert_eq!(
            (code, stderr.lines().count()),
            (Some(2), 1),
            "{arguments:?}: {stderr}"
        );
    }
}

#[test]
fn an_output_path_that_cannot_be_used_is_exit_code_2() {
    let scratch = tempfile::tempdir().unwrap();
    write_recording(&scratch.path().join("given"));
    let import = slipstream(
        scratch.path(),
        &["import", "given", "--out", "no/such/folder.mcap"],
    );
    assert_eq!(import.status.code(), Some(2));
}
