//! An independent parser reads the Perfetto timeline: the trace engine of Chromium's developer tools (npm
//! package @paulirish/trace_engine). Skipped without npm, but a failure if `CI` is set.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::{read_json, run_json, skipped, slipstream};
use serde_json::Value;

const PACKAGE: &str = "@paulirish/trace_engine@0.0.65";

/// Installs the engine and returns its folder; `None` if npm is missing or fails.
fn engine() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("trace-engine");
    let installed = folder.join("installed.txt");
    if std::fs::read_to_string(&installed).is_ok_and(|text| text == PACKAGE) {
        return Some(folder);
    }
    std::fs::create_dir_all(&folder).unwrap();
    let mut npm = Command::new("npm");
    npm.args(["install", "--silent", "--no-save", "--prefix"]);
    match npm.arg(&folder).arg(PACKAGE).output() {
        Ok(output) if output.status.success() => {
            std::fs::write(installed, PACKAGE).unwrap();
            Some(folder)
        }
        Ok(output) => {
            let error = String::from_utf8_lossy(&output.stderr);
            skipped(&format!("npm cannot install {PACKAGE}: {error}"));
            None
        }
        Err(error) => {
            skipped(&format!("npm is not installed: {error}"));
            None
        }
    }
}

#[test]
fn the_trace_engine_finds_each_message_as_an_arrow_over_four_ticks() {
    let Some(engine) = engine() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let keys = ["duration_s=4", "links.delay_s=0.08"];
    let set = keys.iter().flat_map(|key| ["--set", key]);
    let arguments: Vec<&str> = ["--clock", "wall", "--out", "run.mcap"]
        .into_iter()
        .chain(set)
        .collect();
    run_json(folder.path(), &arguments);
    let trace = [
        "trace",
        "run.mcap",
        "--perfetto",
        "timeline.json",
        "--json",
        "trace.json",
    ];
    assert!(slipstream(folder.path(), &trace).status.success());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/external/read_timeline.mjs");
    let output = Command::new("node")
        .arg(script)
        .arg(engine)
        .arg(folder.path().join("timeline.json"))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        seen["processes"],
        serde_json::json!(["plant", "launcher", "recorder", "r1", "r2", "r3"])
    );
    let arrows = seen["arrows"].as_array().unwrap();
    let answer = read_json(&folder.path().join("trace.json"));
    for hop in answer["hops"].as_array().unwrap() {
        let (from, to) = (&hop["from"], &hop["to"]);
        let of_hop = arrows.iter().filter(|arrow| {
            let tick = |i: usize| [&arrow[i][0], &arrow[i][1]].map(|text| text.as_str().unwrap());
            let robots = [from, to].map(|robot| robot.as_str().unwrap());
            assert_eq!(arrow.as_array().unwrap().len(), 4, "{arrow}");
            let t: Vec<f64> = (0..4).map(|i| arrow[i][2].as_f64().unwrap()).collect();
            assert!(t.is_sorted(), "{arrow}");
            [tick(0), tick(1), tick(2), tick(3)]
                == [
                    [robots[0], "outer"],
                    [robots[1], "outer"],
                    [robots[1], "inner"],
                    ["plant", "torque"],
                ]
        });
        assert_eq!(
            of_hop.count() as u64,
            hop["messages"].as_u64().unwrap(),
            "{hop}"
        );
        assert!(hop["messages"].as_u64().unwrap() > 5);
    }
}
