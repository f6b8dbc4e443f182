//! Recording of the trace: it does not change the states, and `RUST_LOG` selects its level.

use slipstream_bus::trace::{self, TraceRecord};

use crate::common::{self, read_json, slipstream};

/// The states are the same without a trace, with it, and with it at any level.
#[test]
fn the_trace_changes_no_state() {
    let folder = tempfile::tempdir().unwrap();
    let run = |set: &str, filter: Option<&str>, mode: &[&str]| {
        let mut arguments = vec![
            "run",
            "--force",
            "--json",
            "result.json",
            "--out",
            "run.mcap",
        ];
        arguments.extend([
            "--set",
            "duration_s=6",
            "--set",
            "links.jitter_s=0.05",
            "--set",
            set,
        ]);
        arguments.extend(mode);
        let mut command = common::command(folder.path(), &arguments);
        if let Some(filter) = filter {
            command.env("RUST_LOG", filter);
        }
        assert!(command.status().unwrap().success());
        let mut names = std::collections::BTreeSet::new();
        let path = folder.path().join("run.mcap");
        let read = slipstream_recording::read_trace(&path, &mut |bytes| {
            let mut collect = |record: TraceRecord<'_>| {
                names.insert(record.name.to_string());
            };
            trace::read(bytes, &mut collect).is_ok()
        });
        assert_eq!(read.is_err(), names.is_empty());
        let hash = read_json(&folder.path().join("result.json"))["state_hash"].clone();
        (hash, names)
    };
    let [on, off] = ["recording.trace=true", "recording.trace=false"];
    let (hash, usual) = run(on, None, &[]);
    for name in [
        "outer", "inner", "sent", "arrived", "taken", "applied", "process", "started",
    ] {
        assert!(usual.contains(name), "{name} is missing in {usual:?}");
    }
    assert!(!usual.contains("reference"));
    for mode in [&[][..], &["--in-process"]] {
        let (other, none) = run(off, None, mode);
        assert_eq!(other, hash);
        assert!(none.is_empty(), "{none:?}");
        let (other, finest) = run(on, Some("slipstream=trace"), mode);
        assert_eq!(other, hash);
        assert!(
            finest.contains("reference") && finest.contains("torque"),
            "{finest:?}"
        );
        let (other, coarse) = run(on, Some("slipstream=info"), mode);
        assert_eq!(other, hash);
        assert!(!coarse.contains("outer"), "{coarse:?}");
    }
    let output = slipstream(folder.path(), &["trace", "run.mcap"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
}

#[test]
fn an_invalid_filter_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for command_line in [&["run"][..], &["run", "--in-process"]] {
        let mut command = common::command(folder.path(), command_line);
        let output = command.env("RUST_LOG", "slipstream=loud").output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(
            stderr.contains("RUST_LOG") && stderr.lines().count() == 1,
            "{stderr}"
        );
    }
}
