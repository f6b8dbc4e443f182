//! Request for an experiment, and the resolved experiment with the origin of every key.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

use slipstream_bus::Experiment;
use slipstream_bus::experiment::Clock;
use slipstream_robots::lab::Lab;

use crate::program::Programs;

/// Request for an experiment, as the command line gives it.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// A built-in experiment or a TOML file; `None`: the platoon.
    pub experiment: Option<String>,
    /// Number of robots.
    pub robots: Option<u32>,
    /// Robot models: for all robots (`None`), or for the named one.
    pub models: Vec<(Option<String>, PathBuf)>,
    /// Programs of agents: the name of a robot, or `*` for all, and a command (`--agent NAME=PROGRAM`).
    pub agents: Vec<(String, String)>,
    /// Keys and values (`--set KEY=VALUE`).
    pub set: Vec<(String, String)>,
    /// The clock.
    pub clock: Option<Clock>,
    /// The seed.
    pub seed: Option<u64>,
    /// `robots.toml`: real robots take the place of the plant.
    pub real: Option<PathBuf>,
}

/// An experiment ready to run.
#[derive(Debug, Clone)]
pub struct Resolved {
    /// The experiment for the processes.
    pub experiment: Experiment,
    /// Every key with its value as TOML and its origin, in order.
    pub keys: Vec<(String, String, Origin)>,
    /// Programs of agents in place of the built-in controller.
    pub programs: Programs,
    /// Assumptions of the experiment, by name.
    pub assumptions: Vec<Assumption>,
    /// The real robots that take the place of the plant.
    pub lab: Option<Lab>,
}

/// An assumption: something unknown, the value taken for it, and the reason.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Assumption {
    /// Its name.
    pub name: String,
    /// The keys that hold the assumed values, with the values as TOML.
    pub keys: BTreeMap<String, String>,
    /// The reason.
    pub reason: String,
}

/// Origin of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The built-in experiment of this name.
    BuiltIn(String),
    /// A file and its line.
    File(PathBuf, usize),
    /// A command-line argument, as it was given.
    Argument(String),
    /// The program of an agent, by its command: a default of its controller.
    Program(String),
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::BuiltIn(name) => write!(f, "built in ({name})"),
            Self::File(path, line) => write!(f, "{}:{line}", path.display()),
            Self::Argument(argument) => write!(f, "{argument}"),
            Self::Program(command) => write!(f, "default of {command}"),
        }
    }
}

impl Resolved {
    /// Every key with its value and, as a comment, its origin; as TOML.
    pub fn to_toml(&self) -> String {
        let width =
            |(key, value, _): &(String, String, Origin)| quoted(key).len() + value.len() + 3;
        let column = self
            .keys
            .iter()
            .map(width)
            .filter(|&w| w < 60)
            .max()
            .unwrap_or(0);
        let mut text = String::new();
        for entry in &self.keys {
            let (key, value, origin) = entry;
            let key_text = quoted(key);
            let gap = " ".repeat(column.saturating_sub(width(entry)));
            // Writing to a string cannot fail.
            let _ = write!(text, "{key_text} = {value}{gap}  # {}", comment(origin));
            // A value given on the command line is no assumption.
            let given = matches!(origin, Origin::Argument(_));
            let own = |assumption: &&Assumption| !given && assumption.keys.contains_key(key);
            for assumption in self.assumptions.iter().filter(own) {
                let _ = write!(text, "; assumption {}", comment(&assumption.name));
            }
            text.push('\n');
        }
        for Assumption { name, reason, .. } in &self.assumptions {
            let name = comment(name);
            let _ = writeln!(text, "# assumption {name}: {}", comment(reason));
        }
        text
    }
}

/// A dotted key as TOML has it: a part with other characters than letters, digits, - and _ needs quotes.
fn quoted(key: &str) -> String {
    let is_bare = |own: char| own.is_ascii_alphanumeric() || own == '-' || own == '_';
    let part = |part: &str| match !part.is_empty() && part.chars().all(is_bare) {
        true => part.to_owned(),
        false => toml::Value::from(part).to_string(),
    };
    key.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// The text as a part of a TOML comment, which is one line without control characters.
fn comment(text: &impl ToString) -> String {
    let text = text.to_string();
    text.replace(|character: char| character.is_control(), " ")
}
