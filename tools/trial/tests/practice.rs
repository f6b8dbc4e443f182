//! Reads the labels of the practice recordings, which lie outside of the repository.
//!
//! `SLIPSTREAM_PRACTICE` names their folder (`../shared/practice` beside the repository if it is not set).
//! The test fails if the variable names a folder without labels; without the variable and without the
//! folder it prints that it was skipped.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::path::{Path, PathBuf};

use slipstream_trial::label;

/// The file of labels; `None` if nobody named a folder and the default one does not exist.
fn labels_file() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("SLIPSTREAM_PRACTICE") {
        let file = Path::new(&folder).join("labels.toml");
        assert!(
            file.exists(),
            "SLIPSTREAM_PRACTICE: {} does not exist",
            file.display()
        );
        return Some(file);
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/practice/labels.toml");
    if !file.exists() {
        println!(
            "skipped: {} does not exist; set SLIPSTREAM_PRACTICE to the folder of the recordings",
            file.display()
        );
        return None;
    }
    Some(file)
}

#[test]
fn labels_made_elsewhere_are_read() {
    let Some(file) = labels_file() else {
        return;
    };
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
