//! Guess of the streams in a text file from its names and first rows.

mod called;
mod columns;
mod guessed;
mod joints;
mod messages;
mod names;
mod pairs;
mod rows;
mod times;
mod units;

use columns::Columns;
pub(super) use guessed::Guessed;

use super::layout::Sample;

/// Files with more columns or robots are not guessed: time grows with their products.
const MOST_COLUMNS: usize = 4096;
const MOST_ROBOTS: usize = 100;

/// The streams that a file seems to have, at most one of a kind for each robot.
pub(super) fn guess(sample: &Sample, file: &str) -> Vec<Guessed> {
    if sample.layout.names.is_empty() {
        return rows::guess(sample, file);
    }
    if sample.layout.names.len() > MOST_COLUMNS {
        return Vec::new();
    }
    let guessed = by_names(sample, file);
    // A comment of as many words as there are columns may be prose.
    if guessed.is_empty() && sample.layout.rows_above == 0 {
        return rows::guess(sample, file);
    }
    guessed
}

/// The streams that the names suggest.
fn by_names(sample: &Sample, file: &str) -> Vec<Guessed> {
    let columns = Columns::of(sample);
    let robots = columns.robots();
    if robots.len() > MOST_ROBOTS {
        return Vec::new();
    }
    if robots.is_empty() {
        return guess_robot(&columns, file);
    }
    let of_robot = |robot: &String| {
        let guessed = guess_robot(&columns.of_robot(robot, robots.len() == 1), file).into_iter();
        let named = guessed.map(|own| Guessed {
            robot: Some(robot.clone()),
            ..own
        });
        named.collect::<Vec<_>>()
    };
    robots.iter().flat_map(of_robot).collect()
}

/// The streams of one robot: fields of messages outweigh names by hand.
fn guess_robot(columns: &Columns<'_>, file: &str) -> Vec<Guessed> {
    let mut guessed = messages::guess(columns, file);
    for new in names::guess(columns) {
        if guessed.iter().all(|old| old.kind != new.kind) {
            guessed.push(new);
        }
    }
    guessed
}
