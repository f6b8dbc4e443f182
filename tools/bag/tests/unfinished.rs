//! A process that ends after a signal removes the files that it has begun.
//!
//! [`remove_unfinished`] is about all files of the process: this test is alone in its program.

#![allow(clippy::unwrap_used, reason = "a failed expectation fails the test")]

use slipstream_bag::output::{OutputFile, remove_unfinished};

#[test]
fn files_that_are_not_whole_are_removed() {
    let scratch = tempfile::tempdir().unwrap();
    let file = OutputFile::create(&scratch.path().join("answer.json")).unwrap();
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 1);
    remove_unfinished();
    assert_eq!(std::fs::read_dir(scratch.path()).unwrap().count(), 0);
    drop(file);
}
