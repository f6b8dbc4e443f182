//! `slipstream robot`, and `--robot` with any description of a robot.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::{Path, PathBuf};

use common::{read_json, slipstream};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A URDF of the tests of the reader.
fn urdf(name: &str) -> String {
    let path = root().join("tools/recording/tests/robot_file").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// Runs a command that must succeed; what it printed.
fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = slipstream(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must refuse its input in one line, which begins so.
fn assert_refused(folder: &Path, arguments: &[&str], message: &str) {
    let output = slipstream(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert_eq!(stderr.trim_end().lines().count(), 1, "{stderr}");
    assert!(stderr.starts_with(message), "{stderr}\n wanted {message}");
    assert!(stderr.contains("; "), "{stderr}");
}

#[test]
fn values_have_their_source() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("turtle.urdf"), urdf("turtle.urdf")).unwrap();
    let text = printed(
        folder.path(),
        &["robot", "turtle.urdf", "--out", "robot.toml"],
    );
    let expected = "\
URDF
wheel_radius_m  0.033 m  cylinder of link wheel_right_link, collision
half_track_m     0.08 m  y of the origins of wheel_right_joint and wheel_left_joint
Wheel joints, right: wheel_right_joint
Wheel joints, left: wheel_left_joint
";
    assert!(text.starts_with(expected), "{text}");
    assert!(text.ends_with("\nrobot.toml\n"), "{text}");
    let again = printed(folder.path(), &["robot", "robot.toml"]);
    assert_eq!(
        again,
        "robot.toml\nwheel_radius_m  0.033 m  the key itself\nhalf_track_m     0.08 m  the key itself\n"
    );
}

#[test]
fn an_existing_file_is_replaced_with_force_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    std::fs::write(file("r.urdf"), urdf("terrain.urdf")).unwrap();
    std::fs::write(file("robot.toml"), "mine").unwrap();
    let command = ["robot", "r.urdf", "--out", "robot.toml"];
    assert_refused(
        folder.path(),
        &command,
        "slipstream: --out robot.toml: exists; give another name, or --force",
    );
    assert_eq!(std::fs::read_to_string(file("robot.toml")).unwrap(), "mine");
    printed(folder.path(), &[&command[..], &["--force"]].concat());
    assert!(
        std::fs::read_to_string(file("robot.toml"))
            .unwrap()
            .contains("half_track_m = 0.29")
    );
}

#[test]
fn what_is_missing_is_said_and_can_be_filled_in() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "<mesh filename=\"wheel.stl\"/>";
    let text = urdf("turtle.urdf").replace("<cylinder length=\"0.018\" radius=\"0.033\"/>", mesh);
    std::fs::write(folder.path().join("mesh.urdf"), text).unwrap();
    let recording = root().join("tests/example/recording");
    let recording = recording.to_string_lossy();
    for command in ["check", "compare", "diagnose"] {
        let arguments = [command, &*recording, "--robot", "mesh.urdf"];
        let message = "slipstream: mesh.urdf: gives no wheel_radius_m: the wheel of wheel_right_joint is a mesh; write";
        assert_refused(folder.path(), &arguments, message);
    }
    assert_refused(
        folder.path(),
        &["run", "--robot", "mesh.urdf"],
        "slipstream: mesh.urdf: gives no wheel_radius_m",
    );
    let text = printed(
        folder.path(),
        &["robot", "mesh.urdf", "--out", "robot.toml"],
    );
    let hint = "measure the radius of the wheels under load and write it (0.033 m if base_footprint lies on the floor";
    assert!(
        text.contains("\nTo fill in:\n- wheel_radius_m: the wheel"),
        "{text}"
    );
    assert!(text.contains(hint), "{text}");
    assert_refused(
        folder.path(),
        &["check", &recording, "--robot", "robot.toml"],
        "slipstream: robot.toml:",
    );
}

/// The same lengths give the same diagnosis, whatever the file.
#[test]
fn every_description_gives_the_same_answer() {
    let folder = tempfile::tempdir().unwrap();
    let model = std::fs::read_to_string(root().join("tests/example/robot.toml")).unwrap();
    let number = |key: &str| {
        let line = model.lines().find(|line| line.starts_with(key)).unwrap();
        line.split(['=', '#']).nth(1).unwrap().trim().to_owned()
    };
    let (radius, half) = (number("wheel_radius_m"), number("half_track_m"));
    let urdf = urdf("turtle.urdf").replace("0.033", &radius);
    let urdf = urdf
        .replace("0.0 0.08 ", &format!("0.0 {half} "))
        .replace("-0.080 ", &format!("-{half} "));
    let track = 2.0 * half.parse::<f64>().unwrap();
    let yaml = format!(
        "c:\n  ros__parameters:\n    wheel_separation: {track}\n    wheel_radius: {radius}\n"
    );
    let toml = format!("format = 1\n[robot]\nwheel_radius_m = {radius}\nhalf_track_m = {half}\n");
    let recording = root().join("tests/example/recording");
    let answers = [("a.urdf", urdf), ("b.yaml", yaml), ("c.toml", toml)].map(|(name, text)| {
        std::fs::write(folder.path().join(name), text).unwrap();
        let arguments = [
            "check",
            &*recording.to_string_lossy(),
            "--robot",
            name,
            "--json",
            "a.json",
        ];
        printed(folder.path(), &arguments);
        let json = ["robot", name, "--json", "b.json"];
        printed(folder.path(), &json);
        let taken = read_json(&folder.path().join("b.json"))["taken"].clone();
        let values: Vec<serde_json::Value> = taken
            .as_array()
            .unwrap()
            .iter()
            .map(|own| own["value"].clone())
            .collect();
        (read_json(&folder.path().join("a.json")), values)
    });
    assert_eq!(answers[0], answers[2]);
    assert_eq!(answers[1], answers[2]);
}

/// A URDF knows no encoders, which the controllers of a run need.
#[test]
fn a_run_takes_what_was_written_of_a_urdf_with_masses() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("complete.urdf"), urdf("complete.urdf")).unwrap();
    let run = |robot| {
        [
            "run",
            "single",
            "--in-process",
            "--no-recording",
            "--robot",
            robot,
        ]
    };
    let message = "slipstream: complete.urdf: encoder.counts_per_rev is missing";
    assert_refused(folder.path(), &run("complete.urdf"), message);
    printed(
        folder.path(),
        &["robot", "complete.urdf", "--out", "robot.toml"],
    );
    let file = folder.path().join("robot.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let filled = text
        .replace("# [encoder]", "[encoder]")
        .replace("# counts_per_rev =", "counts_per_rev = 1856");
    std::fs::write(&file, filled).unwrap();
    printed(folder.path(), &run("robot.toml"));
}

#[test]
fn unusable_files_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let xacro = "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\">\n<xacro:include filename=\"a\"/></robot>";
    let cases = [
        (
            "a.xacro",
            xacro,
            "a.xacro:2: has xacro macros, which are not expanded; run `xacro FILE > robot.urdf` first",
        ),
        (
            "b.urdf",
            "<robot>\n<link/></robot>",
            "b.urdf:2: <link> has no name; add name=",
        ),
        ("c.urdf", "<robot>", "c.urdf:1: "),
        (
            "d.sdf",
            "<sdf/>",
            "d.sdf:1: has <sdf> where a URDF has <robot>",
        ),
        (
            "e.yaml",
            "a:\n  b: 1\n",
            "e.yaml: has no controller with wheel_separation",
        ),
        (
            "f.yaml",
            "a:\n  wheel_separation: wide\n",
            "f.yaml:2: wheel_separation is \"wide\"; give a number",
        ),
        ("g.yaml", "a: [1\nb: 2\n", "g.yaml:"),
        (
            "h.yaml",
            "a:\n  wheel_separation: 1\nb:\n  wheel_separation: 2\n",
            "h.yaml:4: has several controllers",
        ),
        (
            "i.toml",
            "format = 1\n[robo]\n",
            "i.toml:2: robo is not a key",
        ),
        ("j.urdf", "", "j.urdf:"),
    ];
    for (name, text, message) in cases {
        std::fs::write(folder.path().join(name), text).unwrap();
        assert_refused(
            folder.path(),
            &["robot", name, "--out", "robot.toml"],
            &format!("slipstream: {message}"),
        );
        assert!(!folder.path().join("robot.toml").exists());
    }
    assert_refused(
        folder.path(),
        &["robot", "nowhere.urdf"],
        "slipstream: nowhere.urdf: No such file",
    );
    assert_refused(folder.path(), &["robot", "."], "slipstream: .: ");
}

/// A controller with multipliers of the lengths that a URDF has, as robots of ROS 1 are started.
#[test]
fn a_urdf_and_the_yaml_of_its_controller_are_one_robot() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.urdf"), urdf("turtle.urdf")).unwrap();
    let yaml = "base:\n  type: diff_drive_controller/DiffDriveController\n  left_wheel: wheel_left_joint\n  \
                right_wheel: wheel_right_joint\n  wheel_separation_multiplier: 1.5\n";
    std::fs::write(folder.path().join("b.yaml"), yaml).unwrap();
    let message = "slipstream: b.yaml: gives no wheel_radius_m and no half_track_m: base has no wheel_radius, and base has no \
                   wheel_separation; give the robot's URDF, too (--robot robot.urdf --robot b.yaml)";
    let recording = root().join("tests/example/recording");
    let recording = recording.to_string_lossy();
    assert_refused(
        folder.path(),
        &["check", &recording, "--robot", "b.yaml"],
        message,
    );
    let both = ["robot", "a.urdf", "b.yaml", "--json", "c.json"];
    let text = printed(folder.path(), &both);
    assert!(
        text.starts_with("URDF and diff_drive_controller YAML\n"),
        "{text}"
    );
    let answer = read_json(&folder.path().join("c.json"));
    assert_eq!(answer["sources"][1]["file"], "b.yaml");
    assert_eq!(answer["taken"][1]["value"], 0.12);
    let told = [
        "check", &recording, "--robot", "b.yaml", "--robot", "a.urdf",
    ];
    let output = slipstream(folder.path(), &told);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(
        stderr.contains("wheel_radius_m = 0.033, half_track_m = 0.12"),
        "{stderr}"
    );
    // Two of a kind are not of one robot.
    let two = "slipstream: a.urdf: is a second URDF, beside a.urdf; give one URDF for a robot";
    assert_refused(folder.path(), &["robot", "a.urdf", "a.urdf"], two);
}

/// An ERROR of `check` is an exit code, and says what to type.
#[test]
fn check_ends_with_2_beside_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let example = root().join("tests/example/recording");
    let own = folder.path().join("recording");
    for file in [
        "recording.toml",
        "r1/command.csv",
        "r1/wheels.csv",
        "r1/pose.csv",
    ] {
        if let Ok(text) = std::fs::read_to_string(example.join(file)) {
            let to = own.join(file);
            std::fs::create_dir_all(to.parent().unwrap()).unwrap();
            let swapped = text.replacen("ticks_right,ticks_left", "ticks_left,ticks_right", 1);
            std::fs::write(to, swapped).unwrap();
        }
    }
    let model = root().join("tests/example/robot.toml");
    let model = model.to_string_lossy();
    let output = slipstream(folder.path(), &["check", "recording", "--robot", &model]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("ERROR"), "{text}");
    let cure = "exchange the names of the columns in the first line of wheels.csv";
    assert!(text.contains(cure), "{text}");
    let colours = ["check", "recording", "--robot", &model, "--color", "always"];
    let output = slipstream(folder.path(), &colours);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("\u{1b}["), "{text}");
}
