//! The timeline for Perfetto is consistent: arrows touch ticks, spans end.

use serde_json::Value;

use crate::common::{read_json, run_json, slipstream};

/// Each arrow starts, passes and ends at a tick, and each stage that begins also ends.
#[test]
fn arrows_start_pass_and_end_at_ticks() {
    let folder = tempfile::tempdir().unwrap();
    run_json(
        folder.path(),
        &[
            "--in-process",
            "--out",
            "run.mcap",
            "--set",
            "links.delay_s=0.08",
        ],
    );
    let output = slipstream(
        folder.path(),
        &["trace", "run.mcap", "--perfetto", "p.json"],
    );
    assert!(output.status.success());
    let timeline = read_json(&folder.path().join("p.json"));
    let events = timeline["traceEvents"].as_array().unwrap();
    let events_of_phase = |ph: &str| {
        events
            .iter()
            .filter(|event| event["ph"] == ph)
            .collect::<Vec<_>>()
    };
    let position = |event: &Value| format!("{} {} {}", event["pid"], event["tid"], event["ts"]);
    let ticks: std::collections::BTreeSet<String> =
        events_of_phase("X").into_iter().map(position).collect();
    let (starts, steps, ends) = (
        events_of_phase("s"),
        events_of_phase("t"),
        events_of_phase("f"),
    );
    assert!(starts.len() > 100);
    assert_eq!((steps.len(), ends.len()), (2 * starts.len(), starts.len()));
    for arrow in [starts, steps, ends].concat() {
        assert!(ticks.contains(&position(arrow)), "{arrow}");
    }
    assert_eq!(events_of_phase("b").len(), events_of_phase("e").len());
    let processes = events_of_phase("M")
        .into_iter()
        .filter(|event| event["name"] == "process_name");
    let names: Vec<&str> = processes
        .map(|event| event["args"]["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["plant", "r1", "r2", "r3"]);
}
