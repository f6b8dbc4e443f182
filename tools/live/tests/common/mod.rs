//! Helpers of the tests of sources.

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::panic,
    reason = "helpers of tests, each of which needs some"
)]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use slipstream_live::source::{Heard, Source};
use slipstream_recording::Recording;

#[path = "../../../recording/tests/external/rows.rs"]
pub(crate) mod rows_of;

pub(crate) use rows_of::{assert_same, rows};

/// Longer than any machine needs.
pub(crate) const LONG: Duration = Duration::from_secs(120);

/// The bag of the example.
pub(crate) fn cart() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/cart/bag/bag.mcap")
}

/// What a source says until `is_enough`, or until its end.
pub(crate) fn hear_until(
    source: &mut dyn Source,
    mut is_enough: impl FnMut(&[Recording], &[String]) -> bool,
) -> (Vec<Recording>, Vec<String>) {
    let began = Instant::now();
    let (mut pieces, mut said) = (Vec::new(), Vec::new());
    while !is_enough(&pieces, &said) {
        assert!(began.elapsed() < LONG, "too little was heard: {said:?}");
        match source.hear(Duration::from_millis(50)).unwrap() {
            Heard::Rows(piece) => {
                assert_short(&piece);
                pieces.push(piece);
            }
            Heard::Said(text) => said.push(text),
            Heard::Nothing => {}
            Heard::End => break,
        }
    }
    (pieces, said)
}

/// What a source says until its end.
pub(crate) fn hear_all(source: &mut dyn Source) -> (Vec<Recording>, Vec<String>) {
    hear_until(source, |_, _| false)
}

/// A piece is about half a second long. Stamps and times of reception differ a little.
fn assert_short(piece: &Recording) {
    for (stream, rows) in rows([piece]) {
        let times = rows.iter().map(|row| f64::from_bits(row[0]));
        let times: Vec<f64> = times.collect();
        let span_s = times[times.len() - 1] - times[0];
        assert!(span_s < 0.8, "{stream}: {span_s} s");
        assert!(times.is_sorted(), "{stream}");
    }
}
