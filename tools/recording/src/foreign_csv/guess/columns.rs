//! The columns of a file by the words of their names.

use super::units::{is_of_time, words};
use crate::foreign_csv::entry::{Column, ColumnEntry};
use crate::foreign_csv::layout::Sample;

/// Words that, with a number, name a robot: `r1_x`, `/robot_2/odom/…`.
const ROBOTS: [&str; 12] = [
    "r",
    "robot",
    "agent",
    "bot",
    "cart",
    "car",
    "vehicle",
    "rover",
    "ugv",
    "turtlebot",
    "tb",
    "turtle",
];

/// The columns of a file, or those of one robot in it.
pub(super) struct Columns<'a> {
    sample: &'a Sample,
    /// The words of each name with its unit; none for the columns of other robots.
    pub(super) words: Vec<Vec<String>>,
}

impl<'a> Columns<'a> {
    /// All columns.
    pub(super) fn of(sample: &'a Sample) -> Self {
        let names = sample.layout.names.iter().enumerate();
        let words = names.map(|(index, name)| {
            let unit = sample.layout.units.get(index);
            let mut words = words(&format!("{name} {}", unit.map_or("", String::as_str)));
            // The word that `rostopic echo -p` writes before every name.
            if words.len() > 1 && words.first().is_some_and(|word| word == "field") {
                words.remove(0);
            }
            words
        });
        let words = words.collect();
        Self { sample, words }
    }

    /// The robots that names begin with.
    pub(super) fn robots(&self) -> Vec<String> {
        let robots = self.words.iter().filter_map(|name| Some(robot_of(name)?.0));
        let mut robots: Vec<String> = robots.collect();
        robots.sort();
        robots.dedup();
        robots
    }

    /// The columns of one robot, without its name, and those that are of no robot: of several robots, times alone.
    pub(super) fn of_robot(&self, robot: &str, is_only: bool) -> Self {
        let words = self.words.iter().map(|name| match robot_of(name) {
            Some((own, rest)) if own == robot => rest.to_vec(),
            Some(_) => Vec::new(),
            None if is_only || is_of_time(name) => name.clone(),
            None => Vec::new(),
        });
        Self {
            sample: self.sample,
            words: words.collect(),
        }
    }

    /// A column.
    pub(super) fn entry(&self, index: usize, factor: f64) -> ColumnEntry {
        let column = match self.sample.layout.names.get(index) {
            Some(name) if !name.is_empty() => Column::Name(name.clone()),
            _ => Column::Number(index + 1),
        };
        ColumnEntry {
            column,
            factor,
            offset: 0.0,
        }
    }

    /// The name of a column.
    pub(super) fn name(&self, index: usize) -> &str {
        self.sample
            .layout
            .names
            .get(index)
            .map_or("", String::as_str)
    }

    /// The cells of a column in the first rows.
    pub(super) fn cells(&self, index: usize) -> impl Iterator<Item = &'a String> + Clone {
        self.sample
            .rows
            .iter()
            .filter_map(move |row| row.get(index))
    }
}

/// The robot that a name begins with, and what follows.
fn robot_of(name: &[String]) -> Option<(String, &[String])> {
    let (first, rest) = name.split_first()?;
    let stem = first.trim_end_matches(|c: char| c.is_ascii_digit());
    if !ROBOTS.contains(&stem) {
        return None;
    }
    let is_number = |word: &&String| word.bytes().all(|byte| byte.is_ascii_digit());
    let numbers = rest.iter().take_while(is_number).count();
    let (numbers, rest) = rest.split_at_checked(numbers)?;
    if rest.is_empty() || (numbers.is_empty() && stem.len() == first.len()) {
        return None;
    }
    let name = numbers
        .iter()
        .fold(first.clone(), |name, number| format!("{name}_{number}"));
    Some((name, rest))
}
