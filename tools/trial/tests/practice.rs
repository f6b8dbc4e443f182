//! The practice recordings' labels are read, where they are.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

use std::path::Path;

use slipstream_trial::label;

#[test]
fn labels_made_elsewhere_are_read() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/practice/labels.toml");
    if !file.exists() {
        println!("skipped: {} is not there", file.display());
        return;
    }
    let labels = label::read(&file).unwrap();
    assert_eq!(labels.len(), 10);
    assert_eq!(labels["practice-07"].effects.len(), 2);
    assert_eq!(
        labels["practice-06"].unknown.as_ref().unwrap().kind,
        "carpet_strip"
    );
    for label in labels.values() {
        assert!(file.with_file_name(&label.robot_toml).exists());
    }
}
