//! Helpers: runs a platoon and reads its trace.

use std::path::Path;

use serde_json::Value;
use slipstream_trace::{TracedMessage, follow};

use crate::common::{read_json, run_json, slipstream};

/// Runs the platoon and traces its recording run.mcap. Returns the JSON of both commands.
pub(crate) fn traced(folder: &Path, arguments: &[&str]) -> (Value, Value) {
    let run = run_json(folder, &[&["--out", "run.mcap"], arguments].concat());
    let output = slipstream(folder, &["trace", "run.mcap", "--json", "trace.json"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    (run, read_json(&folder.join("trace.json")))
}

/// All messages of a run in one process.
pub(crate) fn messages(arguments: &[&str]) -> Vec<TracedMessage> {
    let folder = tempfile::tempdir().unwrap();
    let mut all = vec!["--in-process", "--out", "run.mcap"];
    all.extend(arguments);
    run_json(folder.path(), &all);
    follow(
        &slipstream_trace::read(&folder.path().join("run.mcap"))
            .unwrap()
            .log,
    )
}
