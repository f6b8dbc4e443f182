//! Recordings without a readable trace: one line and exit code 2.

use crate::common::slipstream;

/// A trace from before the format byte was introduced is refused with a remedy, in one line.
#[test]
fn an_old_trace_is_refused_with_a_remedy() {
    use slipstream_recording::run_writer::{RunHeader, RunWriter};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.mcap");
    let mut writer = RunWriter::create(&path, &RunHeader::default()).unwrap();
    // An inner tick in the old format, which began with the number of the record type.
    writer.write_trace(0, &[6, 0, 0, 0, 0]).unwrap();
    writer.finish().unwrap();
    let output = slipstream(folder.path(), &["trace", "old.mcap"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("old.mcap") && stderr.contains("record it again"),
        "{stderr}"
    );
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}

#[test]
fn input_without_a_trace_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("no.mcap"), "no").unwrap();
    for (input, problem) in [
        ("no.mcap", "MCAP"),
        (".", "folder"),
        ("none.mcap", "No such file"),
    ] {
        let output = slipstream(folder.path(), &["trace", input]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(
            stderr.contains(problem) && stderr.lines().count() == 1,
            "{stderr}"
        );
    }
}
