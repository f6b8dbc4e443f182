//! Guess of the streams in a text file from its names and first rows.

mod guessed;
mod joints;
mod messages;
mod names;
mod rows;
mod times;
mod units;

pub(super) use guessed::Guessed;

use super::layout::Sample;

/// The streams that a file seems to have, at most one of a kind.
pub(super) fn guess(sample: &Sample, file: &str) -> Vec<Guessed> {
    if sample.layout.names.is_empty() {
        return rows::guess(sample);
    }
    let mut guessed = messages::guess(sample, file);
    for new in names::guess(sample) {
        if guessed.iter().all(|old| old.kind != new.kind) {
            guessed.push(new);
        }
    }
    guessed
}
