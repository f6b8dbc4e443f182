//! Robots that take torques: the inner loop drives them, and a drive that gives less than it is told is named from one
//! recording.

use crate::common::read_json;
use crate::lab::{Lab, TORQUE_NM};

#[test]
fn a_weak_drive_of_a_robot_that_takes_torques_is_named() {
    let mut lab = Lab::by_torques(&["", "motor_gain = { right = 0.8, left = 1.0 }"]);
    let run = [
        "run",
        "circle",
        "--clock",
        "wall",
        "--real",
        "robots.toml",
        "--arm",
    ];
    lab.succeeds(&[&run[..], &["--out", "real.mcap", "--json", "real.json"]].concat());
    lab.end_boxes();
    let real = read_json(&lab.file("real.json"));
    for (robot, name) in [(0, "r1.json"), (1, "r2.json")] {
        let told = real["robots"][robot]["real"]["commands"].as_u64().unwrap();
        let ticks = real["duration_s"].as_f64().unwrap() * 50.0;
        assert!(told as f64 > 0.95 * ticks, "{told} of {ticks}");
        for stream in ["odometry", "imu"] {
            let messages = &real["robots"][robot]["real"][stream]["messages"];
            assert!(messages.as_u64().unwrap() > 100, "{stream}: {messages}");
        }
        let seen = read_json(&lab.file(name));
        for side in 0..2 {
            assert!(seen["largest"][side].as_f64().unwrap() <= TORQUE_NM);
        }
    }
    lab.succeeds(&["trace", "real.mcap", "--json", "trace.json"]);
    let topics = read_json(&lab.file("trace.json"))["topics"].clone();
    for (place, topic) in ["wheels", "pose", "odometry", "imu", "command"]
        .iter()
        .enumerate()
    {
        let own = &topics[place];
        assert_eq!(
            (&own["robot"], &own["topic"]),
            (&"r1".into(), &(*topic).into()),
            "{topics}"
        );
        assert!(own["messages"].as_u64().unwrap() > 100, "{own}");
    }
    lab.succeeds(&["diagnose", "real.mcap", "--json", "found.json"]);
    let found = read_json(&lab.file("found.json"));
    let findings = found["findings"].as_array().unwrap();
    let gain = findings
        .iter()
        .find(|own| own["robot"] == "r2" && own["effect"] == "motor_gain");
    let gain = gain.unwrap_or_else(|| panic!("{findings:?}"));
    let parameters = gain["parameters"].as_array().unwrap();
    let right = parameters
        .iter()
        .find(|own| own["name"] == "right")
        .unwrap();
    let estimate = right["estimate"].as_f64().unwrap();
    assert!((estimate - 0.8).abs() < 0.02, "{estimate}");
}
