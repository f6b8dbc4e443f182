//! Which points a study looks at, and which of them a shard does.

use serde::{Deserialize, Serialize};
use slipstream_bus::Experiment;
use slipstream_launch::{Request, Unusable, resolve};

/// Lists of values; every combination is a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// How many robots.
    pub robots: u32,
    /// Runs at each point; run k has the seed k, counted from 1.
    pub runs: u32,
    /// `links.delay_s` (s).
    pub delay_s: Vec<f64>,
    /// `links.jitter_s` (s).
    pub jitter_s: Vec<f64>,
    /// `links.loss` (1).
    pub loss: Vec<f64>,
    /// `control.k_x` (1/s).
    pub k_x: Vec<f64>,
    /// `control.torque_limit`.
    pub torque_limit: Vec<String>,
    /// `links.protocol`.
    pub protocol: Vec<String>,
}

/// One point of the grid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// `links.delay_s` (s).
    pub delay_s: f64,
    /// `links.jitter_s` (s).
    pub jitter_s: f64,
    /// `links.loss` (1).
    pub loss: f64,
    /// `control.k_x` (1/s).
    pub k_x: f64,
    /// `control.torque_limit`.
    pub torque_limit: String,
    /// `links.protocol`.
    pub protocol: String,
    /// `robots.count`.
    pub robots: u32,
}

/// Part `index` of `of`: of every `of` points one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Shard {
    /// Counted from 1.
    pub index: usize,
    /// How many shards there are.
    pub of: usize,
}

impl Default for Grid {
    /// 504 points and 13 runs at each, 6,552 runs. Delays up to half a second are what small radios in a ring
    /// come to; a fifth of all messages lost is a bad day.
    fn default() -> Self {
        Self {
            robots: 3,
            runs: 13,
            delay_s: vec![0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5],
            jitter_s: vec![0.0, 0.05],
            loss: vec![0.0, 0.1, 0.2],
            k_x: vec![0.5, 1.0, 2.0],
            torque_limit: vec!["none".to_owned(), "outer".to_owned()],
            protocol: vec!["ring".to_owned(), "periodic".to_owned()],
        }
    }
}

impl Grid {
    /// Every combination, the delay changing fastest.
    pub fn cells(&self) -> Vec<Cell> {
        let mut cells = Vec::new();
        for protocol in &self.protocol {
            for torque_limit in &self.torque_limit {
                for &k_x in &self.k_x {
                    for &loss in &self.loss {
                        for &jitter_s in &self.jitter_s {
                            cells.extend(self.delay_s.iter().map(|&delay_s| Cell {
                                delay_s,
                                jitter_s,
                                loss,
                                k_x,
                                torque_limit: torque_limit.clone(),
                                protocol: protocol.clone(),
                                robots: self.robots,
                            }));
                        }
                    }
                }
            }
        }
        cells
    }

    /// Whether anything can be asked, in so many parts.
    ///
    /// # Errors
    /// No runs, too few robots for a follower, more shards than points.
    pub fn validate(&self, shard: Shard) -> Result<(), Unusable> {
        let lists = [&self.delay_s, &self.jitter_s, &self.loss, &self.k_x].map(Vec::len);
        let cells = lists.iter().product::<usize>() * self.torque_limit.len() * self.protocol.len();
        if shard.index < 1 || shard.index > shard.of || shard.of > cells {
            return Err(Unusable::new(
                format!("--shard {}/{}", shard.index, shard.of),
                format!("is no part of {cells} points"),
                format!("give at most {cells} shards, counted from 1"),
            ));
        }
        if self.robots < 2 {
            return Err(Unusable::new(
                "--robots",
                format!("is {}", self.robots),
                "give at least 2: the study is about followers",
            ));
        }
        if self.runs == 0 {
            return Err(Unusable::new("--runs", "is 0", "give at least 1"));
        }
        Ok(())
    }
}

impl Shard {
    /// The whole study.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// Whether a point of the grid belongs to this shard.
    pub fn has(self, place: usize) -> bool {
        place % self.of == self.index - 1
    }
}

impl std::str::FromStr for Shard {
    type Err = Unusable;

    fn from_str(text: &str) -> Result<Self, Unusable> {
        let parsed = text.split_once('/').and_then(|(index, of)| {
            Some(Self {
                index: index.parse().ok()?,
                of: of.parse().ok()?,
            })
        });
        parsed
            .filter(|shard| shard.index >= 1 && shard.index <= shard.of)
            .ok_or_else(|| {
                Unusable::new(
                    format!("--shard {text}"),
                    "is no part of a whole",
                    "give I/N with I from 1 to N, such as --shard 1/8",
                )
            })
    }
}

impl Cell {
    /// The keys of `slipstream run --set` that make this point.
    pub fn keys(&self) -> Vec<(String, String)> {
        [
            ("links.delay_s", format!("{:?}", self.delay_s)),
            ("links.jitter_s", format!("{:?}", self.jitter_s)),
            ("links.loss", format!("{:?}", self.loss)),
            ("control.k_x", format!("{:?}", self.k_x)),
            ("control.torque_limit", self.torque_limit.clone()),
            ("links.protocol", self.protocol.clone()),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .to_vec()
    }

    /// The experiment of this point: the platoon with these keys, as `slipstream run` makes it.
    ///
    /// # Errors
    /// A value that the experiment does not take.
    pub fn experiment(&self) -> Result<Experiment, Unusable> {
        let request = Request {
            robots: Some(self.robots),
            set: self.keys(),
            ..Request::default()
        };
        resolve(&request).map(|resolved| resolved.experiment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_whole() {
        let cells = Grid::default().cells().len();
        for of in 1..7 {
            for place in 0..cells {
                let owners = (1..=of).filter(|&index| Shard { index, of }.has(place));
                assert_eq!(owners.count(), 1);
            }
        }
    }

    #[test]
    fn a_shard_that_cannot_be_is_refused() {
        for text in ["0/3", "4/3", "1", "a/b", "1/0", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, of: 3 }));
    }

    #[test]
    fn the_keys_are_those_of_run() {
        let mut cell = Grid::default().cells()[1].clone();
        let experiment = cell.experiment().unwrap();
        assert_eq!(experiment.settings.links.delay_s, cell.delay_s);
        assert_eq!(experiment.settings.control.k_x, cell.k_x);
        cell.protocol = "pigeon".to_owned();
        assert!(cell.experiment().is_err());
    }
}
