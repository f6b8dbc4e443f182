//! Columns that people named by hand for the two sides: `enc_left`, `wheelSpeedR`, `u_l [V]`.

use super::called::COMMANDS;
use super::columns::Columns;
use super::guessed::{Guessed, ONE_OF_SEVERAL};
use super::units::{Dimension, unit_after};
use crate::foreign_csv::entry::{ColumnEntry, Source, TimeEntry};
use crate::sides::{Side, side_of};
use crate::table::StreamKind;

/// What the columns of two sides can be: the words of it, of which a name has at least one.
struct PairQuantity {
    kind: StreamKind,
    /// Right and left.
    columns: [&'static str; 2],
    words: &'static [&'static str],
    /// Whether the name needs a word of commands (`Some(true)`), or must not have one.
    is_command: Option<bool>,
}

/// Words that say nothing of the quantity.
const FILLERS: [&str; 10] = [
    "wheel", "wheels", "motor", "drive", "measured", "actual", "raw", "count", "odom", "state",
];

const QUANTITIES: [PairQuantity; 7] = [
    PairQuantity {
        kind: StreamKind::Wheels,
        columns: ["ticks_right", "ticks_left"],
        words: &[
            "ticks", "tick", "count", "counts", "enc", "encoder", "encoders",
        ],
        is_command: Some(false),
    },
    PairQuantity {
        kind: StreamKind::Wheels,
        columns: ["angle_right_rad", "angle_left_rad"],
        words: &["angle", "pos", "position", "phi", "wheel"],
        is_command: Some(false),
    },
    PairQuantity {
        kind: StreamKind::Wheels,
        columns: ["speed_right_rad_s", "speed_left_rad_s"],
        words: &["speed", "vel", "velocity", "omega", "w"],
        is_command: Some(false),
    },
    PairQuantity {
        kind: StreamKind::Command,
        columns: ["speed_right_rad_s", "speed_left_rad_s"],
        words: &["speed", "vel", "velocity", "omega", "w"],
        is_command: Some(true),
    },
    PairQuantity {
        kind: StreamKind::Command,
        columns: ["voltage_right_v", "voltage_left_v"],
        words: &["voltage", "volts", "u"],
        is_command: None,
    },
    PairQuantity {
        kind: StreamKind::Command,
        columns: ["torque_right_nm", "torque_left_nm"],
        words: &["torque", "tau"],
        is_command: None,
    },
    PairQuantity {
        kind: StreamKind::Motor,
        columns: ["current_right_a", "current_left_a"],
        words: &["current", "i", "amps"],
        is_command: Some(false),
    },
];

/// The streams of two sides, at most one of a kind.
pub(super) fn guess(columns: &Columns<'_>, time: &TimeEntry) -> Vec<Guessed> {
    let mut guessed: Vec<Guessed> = Vec::new();
    for quantity in &QUANTITIES {
        let sides = Side::BOTH.map(|side| quantity.of_side(columns, side));
        let [[right, ..], [left, ..]] = sides.each_ref().map(Vec::as_slice) else {
            continue;
        };
        if guessed.iter().any(|own| own.kind == quantity.kind) {
            continue;
        }
        let sources = [right, left].map(|entry| Source::One(entry.clone()));
        let sources = quantity.columns.into_iter().zip(sources).collect();
        let stream = Guessed::new(quantity.kind, time.clone(), sources);
        let several = sides.iter().any(|side| side.len() > 1);
        guessed.push(if several {
            stream.with_note(ONE_OF_SEVERAL)
        } else {
            stream
        });
    }
    guessed
}

impl PairQuantity {
    /// The columns of one side.
    fn of_side(&self, columns: &Columns<'_>, side: Side) -> Vec<ColumnEntry> {
        let names = columns.words.iter().enumerate();
        let found = names.filter_map(|(index, words)| {
            let (own, words) = split_side(words)?;
            let has_command = words.iter().any(|word| COMMANDS.contains(&word.as_str()));
            if own != side || self.is_command.is_some_and(|wanted| wanted != has_command) {
                return None;
            }
            let factor = self.factor(&words)?;
            Some(columns.entry(index, factor))
        });
        found.collect()
    }

    /// The factor of a name without its side; `None` if it is of another quantity.
    fn factor(&self, words: &[String]) -> Option<f64> {
        let is_own = |word: &&String| self.words.contains(&word.as_str());
        let says_nothing =
            |word: &&String| FILLERS.contains(&word.as_str()) || COMMANDS.contains(&word.as_str());
        let rest: Vec<String> = words
            .iter()
            .filter(|word| !says_nothing(word) || is_own(word))
            .cloned()
            .collect();
        let own = rest.iter().take_while(is_own).count();
        let (name, _) = rest.split_at_checked(own)?;
        let dimension = Dimension::of(self.columns[0]);
        let unit = unit_after(&rest, &name.join(" "), dimension)?;
        // A unit can say what the quantity is: `left_rpm`; for counts, only a name can.
        let is_said = own > 0 || (unit.is_said() && dimension != Dimension::One);
        is_said.then(|| unit.factor())
    }
}

/// The side that a name tells, and the other words. A letter may stand before or after a word: `lenc`, `wr`.
fn split_side(words: &[String]) -> Option<(Side, Vec<String>)> {
    let at = words.iter().position(|word| side_of(word).is_some());
    if let Some(at) = at {
        let side = side_of(words.get(at)?)?;
        let mut rest = words.to_vec();
        let word = rest.remove(at);
        // `lwheel` is a wheel.
        if word.contains("wheel") {
            rest.insert(at, "wheel".to_owned());
        }
        return Some((side, rest));
    }
    let quantities = || QUANTITIES.iter().flat_map(|own| own.words);
    let letters = [("l", Side::Left), ("r", Side::Right)];
    words.iter().enumerate().find_map(|(at, word)| {
        letters.into_iter().find_map(|(letter, side)| {
            let before = word.strip_prefix(letter);
            let bare = before.or_else(|| word.strip_suffix(letter))?;
            let known = quantities().find(|own| **own == bare)?;
            let mut rest = words.to_vec();
            *rest.get_mut(at)? = (*known).to_owned();
            Some((side, rest))
        })
    })
}
