//! The grid of a study.

use serde::{Deserialize, Serialize};
use slipstream_bus::{Experiment, InputError, Shard};
use slipstream_launch::{Request, resolve};

/// Lists of values of each key; every combination is a point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Number of robots.
    pub robots: u32,
    /// Number of runs at each point; the seeds are 1, 2, …
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
pub struct GridCell {
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

impl Default for Grid {
    /// 504 points with 13 runs each, 6,552 runs. Small radios in a ring reach delays of up to half a
    /// second; the loss of a fifth of all messages is a bad link.
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
    /// Every combination; the delay varies fastest.
    pub fn cells(&self) -> Vec<GridCell> {
        let mut cells = Vec::new();
        for protocol in &self.protocol {
            for torque_limit in &self.torque_limit {
                for &k_x in &self.k_x {
                    for &loss in &self.loss {
                        for &jitter_s in &self.jitter_s {
                            cells.extend(self.delay_s.iter().map(|&delay_s| GridCell {
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

    /// The case that the study is first about, at its least delay: of each key the value of the built-in platoon if the list
    /// is the default one, else the first of the list.
    pub fn case(&self) -> Option<GridCell> {
        let default = Self::default();
        let of = |own: &[f64], all: &[f64], usual: f64| match own == all {
            true => Some(usual),
            false => own.first().copied(),
        };
        let named = |own: &[String], all: &[String], usual: &str| match own == all {
            true => Some(usual.to_owned()),
            false => own.first().cloned(),
        };
        Some(GridCell {
            delay_s: self.delay_s.iter().copied().reduce(f64::min)?,
            jitter_s: of(&self.jitter_s, &default.jitter_s, 0.0)?,
            loss: of(&self.loss, &default.loss, 0.0)?,
            k_x: of(&self.k_x, &default.k_x, 1.0)?,
            torque_limit: named(&self.torque_limit, &default.torque_limit, "none")?,
            protocol: named(&self.protocol, &default.protocol, "ring")?,
            robots: self.robots,
        })
    }

    /// Checks the grid and the shard.
    ///
    /// # Errors
    /// No runs, fewer than two robots, a shard that does not exist or more shards than points.
    pub fn validate(&self, shard: Shard) -> Result<(), InputError> {
        let lists = [&self.delay_s, &self.jitter_s, &self.loss, &self.k_x].map(Vec::len);
        let cells = lists.iter().product::<usize>() * self.torque_limit.len() * self.protocol.len();
        shard.validate(cells, "points")?;
        if self.robots < 2 {
            return Err(InputError::new(
                "--robots",
                format!("is {}", self.robots),
                "give at least 2: the study measures followers",
            ));
        }
        if self.runs == 0 {
            return Err(InputError::new("--runs", "is 0", "give at least 1"));
        }
        Ok(())
    }
}

impl GridCell {
    /// The same at another delay (s).
    #[must_use]
    pub fn at(&self, delay_s: f64) -> Self {
        Self {
            delay_s,
            ..self.clone()
        }
    }

    /// The keys of `slipstream run --set` for this point.
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

    /// The experiment of this point: the built-in platoon with these keys, as `slipstream run`
    /// resolves it.
    ///
    /// # Errors
    /// A value that the experiment does not accept.
    pub fn experiment(&self) -> Result<Experiment, InputError> {
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

    /// The usual values of the default grid are those of the built-in platoon.
    #[test]
    fn the_case_is_the_platoon_or_the_first_of_each_list() {
        let case = Grid::default().case().unwrap();
        let usual = case.experiment().unwrap().settings;
        let platoon = resolve(&Request::default()).unwrap().experiment.settings;
        assert_eq!(
            (&usual.links, &usual.control),
            (&platoon.links, &platoon.control)
        );
        let grid = Grid {
            delay_s: vec![0.3, 0.1],
            k_x: vec![2.0, 1.0],
            ..Grid::default()
        };
        let case = grid.case().unwrap();
        assert_eq!((case.delay_s, case.k_x), (0.1, 2.0));
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
