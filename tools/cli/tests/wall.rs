//! Runs on the wall clock: deadlines, deaths, and coming back.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

mod common;

use std::time::Duration;

use common::{command, lives, read_json, roles, run_json, wait_for};
use rustix::process::{Pid, Signal, kill_process};

/// On a machine that tests share, deadlines may be missed; they must be counted, all of them.
#[test]
fn every_deadline_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--clock",
        "wall",
        "--set",
        "duration_s=3",
        "--set",
        "links.delay_s=0.08",
    ];
    let result = run_json(folder.path(), &arguments);
    let ticks = |process: &str, name: &str| {
        let loops = result["deadlines"].as_array().unwrap().iter();
        let mut found = loops.filter(|d| d["process"] == process && d["loop"] == name);
        found.next().unwrap()["ticks"].as_u64().unwrap()
    };
    assert_eq!(ticks("plant", "step"), 3000);
    for robot in ["r1", "r2", "r3"] {
        // The run ends with the plant: the last tick may or may not fall into it.
        assert!(ticks(robot, "outer").abs_diff(60) <= 1);
        assert!(ticks(robot, "inner").abs_diff(150) <= 1);
    }
    // Both clocks tell the same story.
    let other = run_json(folder.path(), &["--set", "duration_s=3", "--in-process"]);
    let end = |result: &serde_json::Value| result["robots"][0]["final_true"][0].as_f64().unwrap();
    assert!((end(&result) - end(&other)).abs() < 0.05);
    assert!(result["wall_s"].as_f64().unwrap() > 3.0);
}

/// Kills r2 in the middle and gives the result.
fn kill_r2(on_death: &str) -> (serde_json::Value, Option<i32>, String) {
    let folder = tempfile::tempdir().unwrap();
    let key = format!("on_death={on_death}");
    let arguments = [
        "run",
        "--clock",
        "wall",
        "--set",
        &key,
        "--set",
        "duration_s=7",
        "--json",
        "result.json",
        "--set",
        "formation.start_s=1",
    ];
    let launcher = command(folder.path(), &arguments).spawn().unwrap();
    let mut victim = None;
    wait_for("start", Duration::from_secs(20), || {
        let is_r2 = |words: &[String]| words.windows(2).any(|w| w[0] == "--robot" && w[1] == "1");
        victim = roles(launcher.id())
            .into_iter()
            .find(|role| is_r2(&role.arguments));
        victim.is_some()
    });
    std::thread::sleep(Duration::from_millis(2500));
    let pid = victim.unwrap().pid;
    kill_process(
        Pid::from_raw(i32::try_from(pid).unwrap()).unwrap(),
        Signal::KILL,
    )
    .unwrap();
    let output = launcher.wait_with_output().unwrap();
    assert!(!lives(pid));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("r2 (pid"), "{words}");
    (
        read_json(&folder.path().join("result.json")),
        output.status.code(),
        words,
    )
}

/// The others go on; the follower of the dead one stops by its watchdog.
#[test]
fn a_run_goes_on_without_a_dead_agent() {
    let (result, code, words) = kill_r2("continue");
    assert_eq!(code, Some(1), "{words}");
    assert!((result["duration_s"].as_f64().unwrap() - 7.0).abs() < 1e-9);
    let robot = |i: usize| &result["robots"][i];
    assert!(robot(1)["final_odometry"].is_null());
    assert!(
        robot(0)["final_odometry"][0].as_f64().unwrap() > 1.9,
        "{result}"
    );
    // r3 has slowed down and stands well behind where it would have been.
    let behind =
        robot(0)["final_true"][0].as_f64().unwrap() - robot(2)["final_true"][0].as_f64().unwrap();
    assert!(behind > 1.2192 + 0.5, "{behind}");
}

/// A dead agent is started again and goes on where it was.
#[test]
fn a_dead_agent_comes_back() {
    let (result, code, words) = kill_r2("restart");
    assert_eq!(code, Some(1), "{words}");
    let agents = result["processes"].as_array().unwrap().iter();
    assert_eq!(agents.filter(|process| process["robot"] == "r2").count(), 2);
    let robot = &result["robots"][1];
    let [believed, driven] =
        ["final_odometry", "final_true"].map(|key| robot[key][0].as_f64().unwrap());
    // Its odometry went on from its predecessor's, not from the start.
    assert!((believed - driven).abs() < 0.15, "{believed} {driven}");
    assert!(driven > 1.0, "{driven}");
}
