//! A part of a study or trial, for the array jobs of a cluster, and the whole from all its parts.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::InputError;

/// Missing shards that an error lists.
const MISSING_LISTED: usize = 8;

/// Part `index` of `of`: every `of`-th item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// Counted from 1.
    pub index: usize,
    /// Number of shards.
    pub of: usize,
}

impl Shard {
    /// All items.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// Whether the item with this index belongs to this shard.
    pub fn has(self, index: usize) -> bool {
        index % self.of == self.index - 1
    }

    /// The items of this shard, in their order.
    pub fn pick<T>(self, items: impl IntoIterator<Item = T>) -> Vec<T> {
        let all = items.into_iter().enumerate();
        all.filter_map(|(index, item)| self.has(index).then_some(item))
            .collect()
    }

    /// Checks that the shard exists and has an item. `items` says what is divided: `points`, `cases`.
    ///
    /// # Errors
    /// A shard that does not exist, or more shards than items.
    pub fn validate(self, count: usize, items: &str) -> Result<(), InputError> {
        if self.index >= 1 && self.index <= self.of && self.of <= count {
            return Ok(());
        }
        Err(InputError::new(
            format!("--shard {self}"),
            format!("there are {count} {items}"),
            format!("give at most {count} shards, counted from 1"),
        ))
    }

    /// All shards in their order, from files in any order. `what` is what was divided: `study`, `trial`;
    /// `same` says whether two files are parts of the same.
    ///
    /// # Errors
    /// A shard of another whole, one that does not exist, one given twice, one that is missing.
    pub fn in_order<'a, T>(
        files: &'a [(String, T)],
        what: &str,
        shard: impl Fn(&T) -> Self,
        same: impl Fn(&T, &T) -> bool,
    ) -> Result<Vec<&'a T>, InputError> {
        let Some((first_name, first)) = files.first() else {
            return Err(InputError::new(
                "FILE",
                "is missing",
                "give the shards' files",
            ));
        };
        let of = shard(first).of;
        let mut parts = BTreeMap::new();
        for (name, part) in files {
            let own = shard(part);
            if own.of != of || !same(first, part) {
                let problem = format!("is of another {what} than {first_name}");
                let remedy = "merge shards of one command line";
                return Err(InputError::new(name, problem, remedy));
            }
            if own.index < 1 || own.index > of {
                let problem = format!("says that it is shard {own}");
                return Err(InputError::new(name, problem, "run it again"));
            }
            if parts.insert(own.index, part).is_some() {
                let problem = format!("is shard {own} a second time");
                return Err(InputError::new(name, problem, "give each shard once"));
            }
        }
        if parts.len() < of {
            let missing = (1..=of).filter(|index| !parts.contains_key(index));
            return Err(missing_shards(
                missing.take(MISSING_LISTED + 1).collect(),
                of,
            ));
        }
        Ok(parts.into_values().collect())
    }
}

/// The error about missing shards. The list has the form of `sbatch --array`.
fn missing_shards(mut missing: Vec<usize>, of: usize) -> InputError {
    if let [index] = missing[..] {
        return InputError::new(
            "FILE",
            format!("shard {index}/{of} is missing"),
            format!("run it with --shard {index}/{of} and give its file too"),
        );
    }
    let more = if missing.len() > MISSING_LISTED {
        ",…"
    } else {
        ""
    };
    missing.truncate(MISSING_LISTED);
    let list: Vec<String> = missing.iter().map(usize::to_string).collect();
    InputError::new(
        "FILE",
        format!("shards {}{more} of {of} are missing", list.join(",")),
        format!("run each with --shard I/{of} and give their files too"),
    )
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl std::str::FromStr for Shard {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let parsed = text.split_once('/').and_then(|(index, of)| {
            Some(Self {
                index: index.parse().ok()?,
                of: of.parse().ok()?,
            })
        });
        parsed
            .filter(|shard| shard.index >= 1 && shard.index <= shard.of)
            .ok_or_else(|| {
                InputError::new(
                    format!("--shard {text}"),
                    "is not a valid shard",
                    "give I/N with I from 1 to N, such as --shard 1/8",
                )
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_belongs_to_one_shard() {
        for of in 1..7 {
            let parts = (1..=of).map(|index| Shard { index, of }.pick(0..20));
            let mut all: Vec<usize> = parts.flatten().collect();
            all.sort_unstable();
            assert_eq!(all, (0..20).collect::<Vec<_>>());
        }
        assert_eq!(Shard { index: 2, of: 3 }.pick(0..8), [1, 4, 7]);
    }

    #[test]
    fn an_invalid_shard_is_refused() {
        for text in ["0/3", "4/3", "1", "a/b", "1/0", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, of: 3 }));
        assert!(Shard { index: 1, of: 4 }.validate(3, "points").is_err());
        assert!(Shard { index: 3, of: 3 }.validate(3, "points").is_ok());
    }

    /// Merges files of these shards; shards beyond 90 are of another whole.
    fn merged(shards: &[&str]) -> Result<Vec<usize>, String> {
        let files: Vec<(String, Shard)> = shards
            .iter()
            .map(|text| {
                let (index, of) = text.split_once('/').unwrap();
                let [index, of] = [index, of].map(|number| number.parse().unwrap());
                (format!("{index}.json"), Shard { index, of })
            })
            .collect();
        let same = |a: &Shard, b: &Shard| (a.index > 90) == (b.index > 90);
        let parts = Shard::in_order(&files, "study", |shard| *shard, same);
        let parts = parts.map_err(|error| error.to_string())?;
        Ok(parts.into_iter().map(|shard| shard.index).collect())
    }

    #[test]
    fn files_are_put_in_order_or_refused() {
        assert_eq!(merged(&["2/3", "3/3", "1/3"]), Ok(vec![1, 2, 3]));
        for (shards, words) in [
            (
                &["2/3", "1/3"][..],
                "FILE: shard 3/3 is missing; run it with --shard 3/3",
            ),
            (
                &["2/4", "1/4"],
                "FILE: shards 3,4 of 4 are missing; run each with --shard I/4",
            ),
            (
                &["1/999999999999"],
                "shards 2,3,4,5,6,7,8,9,… of 999999999999 are missing",
            ),
            (
                &["1/2", "1/2"],
                "1.json: is shard 1/2 a second time; give each shard once",
            ),
            (
                &["1/2", "2/3"],
                "2.json: is of another study than 1.json; merge",
            ),
            (
                &["1/2", "95/2"],
                "95.json: is of another study than 1.json; merge",
            ),
            (
                &["1/2", "3/2"],
                "3.json: says that it is shard 3/2; run it again",
            ),
            (&[], "FILE: is missing; give the shards' files"),
        ] {
            let error = merged(shards).unwrap_err();
            assert!(error.starts_with(words) || error.contains(words), "{error}");
        }
    }
}
