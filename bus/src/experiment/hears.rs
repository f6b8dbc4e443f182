//! Key `links.topology`: who hears whom, by a name or as a list of links.

use std::fmt;
use std::str::FromStr;

use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::message::{RobotIndex, robot_name};

/// Who hears whom.
///
/// As text it is a name, or links such as `r1>r2 r2>r3`; a file may also give a list of pairs, `[["r1", "r2"]]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Hears {
    /// Every robot hears the one ahead.
    Predecessor,
    /// Every robot hears the front robot and the one ahead.
    LeaderPredecessor,
    /// Every robot hears the two ahead.
    TwoPredecessors,
    /// As `predecessor`, and the front robot hears the last one.
    Ring,
    /// Every robot hears all others.
    All,
    /// These links: sender and receiver.
    Links(Vec<[RobotIndex; 2]>),
}

/// The names.
const NAMES: [(&str, Hears); 5] = [
    ("predecessor", Hears::Predecessor),
    ("leader_predecessor", Hears::LeaderPredecessor),
    ("two_predecessors", Hears::TwoPredecessors),
    ("ring", Hears::Ring),
    ("all", Hears::All),
];

impl fmt::Display for Hears {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Self::Links(links) = self {
            for (index, &[from, to]) in links.iter().enumerate() {
                let gap = if index == 0 { "" } else { " " };
                write!(f, "{gap}{}>{}", robot_name(from), robot_name(to))?;
            }
            return Ok(());
        }
        let found = NAMES.iter().find(|(_, named)| named == self);
        f.write_str(found.map_or("", |(name, _)| name))
    }
}

impl FromStr for Hears {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, named)) = NAMES.iter().find(|(name, _)| *name == text.trim()) {
            return Ok(named.clone());
        }
        let link = |text: &str| {
            let (from, to) = text.split_once('>')?;
            Some([robot(from)?, robot(to)?])
        };
        let links: Option<Vec<[RobotIndex; 2]>> = text.split_whitespace().map(link).collect();
        links.map(Self::Links).ok_or_else(|| {
            let names = NAMES.map(|(name, _)| name).join(", ");
            format!("{text:?} is neither one of {names} nor links such as \"r1>r2 r2>r3\"")
        })
    }
}

/// The index of a robot by its name.
fn robot(name: &str) -> Option<RobotIndex> {
    let number: RobotIndex = name.strip_prefix('r')?.parse().ok()?;
    number.checked_sub(1)
}

impl Serialize for Hears {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for Hears {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_any(TextOrPairs)
        } else {
            deserializer.deserialize_str(TextOrPairs)
        }
    }
}

struct TextOrPairs;

impl<'de> Visitor<'de> for TextOrPairs {
    type Value = Hears;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a topology by its name, or links")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Hears, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut pairs: A) -> Result<Hears, A::Error> {
        let mut links = Vec::new();
        while let Some([from, to]) = pairs.next_element::<[String; 2]>()? {
            let link = format!("{from}>{to}").parse();
            let Ok(Hears::Links(link)) = link else {
                let problem = format!("[{from:?}, {to:?}] is no link from robot to robot");
                return Err(serde::de::Error::custom(problem));
            };
            links.extend(link);
        }
        Ok(Hears::Links(links))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_links_survive_text_and_bytes() {
        for text in ["predecessor", "two_predecessors", "all", "r1>r2 r1>r12", ""] {
            let topology: Hears = text.parse().unwrap();
            assert_eq!(topology.to_string(), text);
            let bytes = postcard::to_allocvec(&topology).unwrap();
            assert_eq!(postcard::from_bytes::<Hears>(&bytes).unwrap(), topology);
        }
        for text in ["predecesor", "r1", "r0>r1", "r1>x2"] {
            assert!(text.parse::<Hears>().is_err(), "{text}");
        }
    }
}
