//! Runs on the wall clock: deadlines, dead agents, and restarts.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::time::Duration;

use common::{command, is_alive, read_json, roles, run_json, wait_for};
use rustix::process::{Pid, Signal, kill_process};

/// Deadlines may be missed on a loaded machine, but every tick must be counted.
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
    // The run on the virtual clock ends at the same position.
    let virtual_run = run_json(folder.path(), &["--set", "duration_s=3", "--in-process"]);
    let end = |result: &serde_json::Value| result["robots"][0]["final_true"][0].as_f64().unwrap();
    assert!((end(&result) - end(&virtual_run)).abs() < 0.05);
    assert!(result["wall_s"].as_f64().unwrap() > 3.0);
}

/// Kills the agent of r2 during a run. Returns the summary, the exit code and standard error.
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
        let is_r2 = |arguments: &[String]| {
            arguments
                .windows(2)
                .any(|w| w[0] == "--robot" && w[1] == "1")
        };
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
    assert!(!is_alive(pid));
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(stderr.contains("r2 (pid"), "{stderr}");
    // The recording holds the death as an event, which is text and therefore left out of the import.
    let recording = slipstream_recording::read(&folder.path().join("platoon.mcap")).unwrap();
    assert!(
        recording
            .left_out
            .get("/events")
            .is_some_and(|&events| events > 0)
    );
    (
        read_json(&folder.path().join("result.json")),
        output.status.code(),
        stderr,
    )
}

/// The other robots continue; the watchdog stops the follower of r2.
#[test]
fn the_run_continues_without_a_dead_agent() {
    let (result, code, stderr) = kill_r2("continue");
    assert_eq!(code, Some(1), "{stderr}");
    assert!((result["duration_s"].as_f64().unwrap() - 7.0).abs() < 1e-9);
    let robot = |i: usize| &result["robots"][i];
    assert!(robot(1)["final_odometry"].is_null());
    assert!(
        robot(0)["final_odometry"][0].as_f64().unwrap() > 1.9,
        "{result}"
    );
    // r3 has stopped, at least 0.5 m behind its place in the formation.
    let behind =
        robot(0)["final_true"][0].as_f64().unwrap() - robot(2)["final_true"][0].as_f64().unwrap();
    assert!(behind > 1.2192 + 0.5, "{behind}");
}

/// A dead agent is restarted and resumes from its last state.
#[test]
fn a_dead_agent_is_restarted() {
    let (result, code, stderr) = kill_r2("restart");
    assert_eq!(code, Some(1), "{stderr}");
    let agents = result["processes"].as_array().unwrap().iter();
    assert_eq!(agents.filter(|process| process["robot"] == "r2").count(), 2);
    let robot = &result["robots"][1];
    let [odometry_m, true_m] =
        ["final_odometry", "final_true"].map(|key| robot[key][0].as_f64().unwrap());
    // The odometry continues that of the dead agent instead of starting again.
    assert!((odometry_m - true_m).abs() < 0.15, "{odometry_m} {true_m}");
    assert!(true_m > 1.0, "{true_m}");
}
