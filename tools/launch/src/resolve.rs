//! The experiment as it will be run: a built-in one, a file over it, flags over both; every key
//! with where it came from.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use slipstream_agents::Node;
use slipstream_bus::experiment::{Clock, Settings};
use slipstream_bus::message::robot_name;
use slipstream_bus::{Experiment, InputError, RobotModel, RobotSetup};
use slipstream_recording::robot_toml;
use toml::{Table, Value};

use crate::keys;
use crate::round_trips;

/// What the command line asks for.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// A built-in experiment or a file; the platoon where not given.
    pub experiment: Option<String>,
    /// How many robots.
    pub robots: Option<u32>,
    /// Robot models: for all, or for the named one.
    pub models: Vec<(Option<String>, PathBuf)>,
    /// Keys and values.
    pub set: Vec<(String, String)>,
    /// The clock.
    pub clock: Option<Clock>,
    /// The seed.
    pub seed: Option<u64>,
}

/// An experiment ready to run.
#[derive(Debug, Clone)]
pub struct Resolved {
    /// What the processes get.
    pub experiment: Experiment,
    /// Every key in its order, its value as TOML, and where it came from.
    pub keys: Vec<(String, String, Origin)>,
    /// What the experiment assumes, by name.
    pub assumptions: Vec<Assumption>,
}

/// Something that is not known, what is taken for it, and why.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Assumption {
    /// Its name.
    pub name: String,
    /// The keys that hold what is taken, with their values as TOML.
    pub keys: BTreeMap<String, String>,
    /// Why.
    pub reason: String,
}

/// Where a key's value came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The built-in experiment of this name.
    BuiltIn(String),
    /// A file and its line.
    File(PathBuf, usize),
    /// An argument, as it stands on the command line.
    Argument(String),
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::BuiltIn(name) => write!(f, "built in ({name})"),
            Self::File(path, line) => write!(f, "{}:{line}", path.display()),
            Self::Argument(argument) => write!(f, "{argument}"),
        }
    }
}

/// The names of the built-in experiments.
pub const BUILT_IN: [&str; 5] = ["platoon", "single", "circle", "figure_eight", "lane_change"];

/// The keys while they are gathered.
struct Tree {
    table: Table,
    base: String,
    origins: BTreeMap<String, Origin>,
    /// Keys and reason, by name.
    assumed: BTreeMap<String, (Vec<String>, String)>,
}

/// The files of the paper's experiments.
const PAPERS: [(&str, &str); 2] = [
    ("platoon", include_str!("../experiments/platoon.toml")),
    ("single", include_str!("../experiments/single.toml")),
];

/// Resolves what is asked for.
///
/// # Errors
/// A key, value or file that cannot be used.
pub fn resolve(request: &Request) -> Result<Resolved, InputError> {
    let mut tree = base(request.experiment.as_deref())?;
    for (key, value) in &request.set {
        let argument = Origin::Argument(format!("--set {key}={value}"));
        tree.set(key, keys::parse_value(value), &argument)?;
    }
    if let Some(robots) = request.robots {
        let argument = Origin::Argument(format!("--robots {robots}"));
        tree.set("robots.count", Value::Integer(robots.into()), &argument)?;
    }
    if let Some(seed) = request.seed {
        let argument = Origin::Argument(format!("--seed {seed}"));
        let seed = i64::try_from(seed).map_err(|_| {
            InputError::new(
                "--seed",
                format!("is {seed}"),
                format!("give at most {}", i64::MAX),
            )
        })?;
        tree.set("seed", Value::Integer(seed), &argument)?;
    }
    if let Some(clock) = request.clock {
        let name = if clock == Clock::Wall {
            "wall"
        } else {
            "virtual"
        };
        let argument = Origin::Argument(format!("--clock {name}"));
        tree.set("clock", Value::String(name.to_owned()), &argument)?;
    }
    for (_, path) in request.models.iter().filter(|(name, _)| name.is_none()) {
        let argument = Origin::Argument(format!("--robot {}", path.display()));
        tree.set(
            "robots.model",
            Value::String(path.display().to_string()),
            &argument,
        )?;
    }
    let settings = tree.settings()?;
    settings.validate().map_err(|error| {
        let problem = format!("{} {}", error.place, error.problem);
        InputError::new(tree.place_of(&error.place), problem, error.remedy)
    })?;
    let experiment = Experiment {
        robots: robots(&settings, &tree, &request.models)?,
        half_round_trips_ns: match settings.links.trace.as_str() {
            "" => Vec::new(),
            trace => round_trips::read(&tree.path("links.trace", trace))?,
        },
        settings,
    };
    judge(&experiment, &request.models)?;
    Ok(Resolved {
        experiment,
        keys: tree.listing(),
        assumptions: tree.assumptions(),
    })
}

impl Resolved {
    /// Every key with its value and where it came from, as TOML.
    pub fn to_toml(&self) -> String {
        let width = |(key, value, _): &(String, String, Origin)| key.len() + value.len() + 3;
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
            let gap = " ".repeat(column.saturating_sub(width(entry)));
            // Writing to a string cannot fail.
            let _ = write!(text, "{key} = {value}{gap}  # {origin}");
            // What somebody says on the command line is no assumption.
            let said = matches!(origin, Origin::Argument(_));
            let own = |assumption: &&Assumption| !said && assumption.keys.contains_key(key);
            for assumption in self.assumptions.iter().filter(own) {
                let _ = write!(text, "; assumption {}", assumption.name);
            }
            text.push('\n');
        }
        for Assumption { name, reason, .. } in &self.assumptions {
            let reason = reason.replace('\n', " ");
            let _ = writeln!(text, "# assumption {name}: {reason}");
        }
        text
    }
}

/// The built-in experiment, or the one that a file is laid over, with the file laid over it.
fn base(experiment: Option<&str>) -> Result<Tree, InputError> {
    let asked = experiment.unwrap_or("platoon");
    if let Some(tree) = Tree::built_in(asked)? {
        return Ok(tree);
    }
    let path = Path::new(asked);
    let text = std::fs::read_to_string(path).map_err(|error| {
        let remedy = format!("give a file, or one of {}", BUILT_IN.join(", "));
        InputError::new(asked, format!("cannot be read: {error}"), remedy)
    })?;
    let file = keys::File::parse(path, &text)?;
    let name = file.base().unwrap_or("platoon");
    let mut tree = Tree::built_in(name)?.ok_or_else(|| {
        let remedy = format!("give one of {}", BUILT_IN.join(", "));
        InputError::new(file.place("base"), format!("base is {name:?}"), remedy)
    })?;
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    tree.set(
        "name",
        Value::String(stem),
        &Origin::File(path.to_owned(), 1),
    )?;
    for (key, value, line) in file.keys() {
        tree.set(&key, value, &Origin::File(path.to_owned(), line))?;
    }
    tree.assume(&file)?;
    Ok(tree)
}

impl Tree {
    fn built_in(name: &str) -> Result<Option<Self>, InputError> {
        let Some(mut tree) = Self::plain(name) else {
            return Ok(None);
        };
        for (_, text) in PAPERS.iter().filter(|(paper, _)| *paper == name) {
            let file = keys::File::parse(Path::new(name), text)?;
            for (key, value, _) in file.keys() {
                tree.set(&key, value, &Origin::BuiltIn(name.to_owned()))?;
            }
            tree.assume(&file)?;
        }
        Ok(Some(tree))
    }

    /// The settings of a built-in experiment, before its file.
    fn plain(name: &str) -> Option<Self> {
        let settings = match name {
            "platoon" => Settings::default(),
            "single" => Settings::single(),
            "circle" => Settings::circle(),
            "figure_eight" => Settings::figure_eight(),
            "lane_change" => Settings::lane_change(),
            _ => return None,
        };
        let table = Table::try_from(settings).ok()?;
        Some(Self {
            table,
            base: name.to_owned(),
            origins: BTreeMap::new(),
            assumed: BTreeMap::new(),
        })
    }

    /// Takes in what a file assumes.
    fn assume(&mut self, file: &keys::File) -> Result<(), InputError> {
        for (name, keys, reason) in file.assumptions()? {
            if let Some(key) = keys
                .iter()
                .find(|key| keys::find(&self.table, key).is_none())
            {
                let place = file.place(&format!("assumptions.{name}.keys"));
                let remedy = match keys::nearest(&self.table, key) {
                    Some(near) => format!("did you mean {near}? --dry-run lists all keys"),
                    None => "--dry-run lists all keys".to_owned(),
                };
                return Err(InputError::new(place, format!("{key} is no key"), remedy));
            }
            self.assumed.insert(name, (keys, reason));
        }
        Ok(())
    }

    fn assumptions(&self) -> Vec<Assumption> {
        let value = |key: &String| keys::find(&self.table, key).map(ToString::to_string);
        let with_value = |key: &String| Some((key.clone(), value(key)?));
        let one = |(name, (keys, reason)): (&String, &(Vec<String>, String))| Assumption {
            name: name.clone(),
            keys: keys.iter().filter_map(with_value).collect(),
            reason: reason.clone(),
        };
        self.assumed.iter().map(one).collect()
    }

    /// Sets one key; what the settings do not take is refused at once, where it stands.
    fn set(&mut self, key: &str, value: Value, origin: &Origin) -> Result<(), InputError> {
        let place = || origin.to_string();
        let before = keys::find(&self.table, key).ok_or_else(|| {
            let remedy = match keys::nearest(&self.table, key) {
                Some(near) => format!("did you mean {near}? --dry-run lists all keys"),
                None => "--dry-run lists all keys".to_owned(),
            };
            InputError::new(place(), format!("{key} is no key"), remedy)
        })?;
        let value = keys::fit(before, value).map_err(|wanted| {
            InputError::new(
                place(),
                format!("{key} is no {wanted}"),
                format!("give a {wanted}"),
            )
        })?;
        let mut table = self.table.clone();
        keys::replace(&mut table, key, value);
        Settings::deserialize(table.clone()).map_err(|error| {
            let reason = error
                .message()
                .lines()
                .next()
                .unwrap_or_default()
                .to_owned();
            InputError::new(
                place(),
                format!("{key}: {reason}"),
                "give a value that fits",
            )
        })?;
        self.table = table;
        self.origins.insert(key.to_owned(), origin.clone());
        Ok(())
    }

    fn settings(&self) -> Result<Settings, InputError> {
        Settings::deserialize(self.table.clone())
            .map_err(|error| InputError::new(&self.base, error.message(), "mend the experiment"))
    }

    fn origin(&self, key: &str) -> Origin {
        let built_in = || Origin::BuiltIn(self.base.clone());
        self.origins.get(key).cloned().unwrap_or_else(built_in)
    }

    /// Where to look for what is wrong with a key.
    fn place_of(&self, key: &str) -> String {
        let inside = |other: &&String| other.starts_with(&format!("{key}."));
        match self.origins.keys().find(inside) {
            Some(inner) => self.origin(inner).to_string(),
            None => self.origin(key).to_string(),
        }
    }

    /// A path that a key names: relative to the file in which it stands.
    fn path(&self, key: &str, named: &str) -> PathBuf {
        match self.origin(key) {
            Origin::File(file, _) => file.parent().unwrap_or(Path::new("")).join(named),
            _ => PathBuf::from(named),
        }
    }

    fn listing(&self) -> Vec<(String, String, Origin)> {
        keys::leaves(&self.table)
            .into_iter()
            .map(|(key, value)| {
                let origin = self.origin(&key);
                (key, value.to_string(), origin)
            })
            .collect()
    }
}

/// The robots from the front, each with its model.
fn robots(
    settings: &Settings,
    tree: &Tree,
    models: &[(Option<String>, PathBuf)],
) -> Result<Vec<RobotSetup>, InputError> {
    let all = match settings.robots.model.as_str() {
        "" => RobotModel::paper_with_slip(),
        path => read_model(&tree.path("robots.model", path))?,
    };
    let mut robots: Vec<RobotSetup> = (0..settings.robots.count)
        .map(|index| RobotSetup {
            name: robot_name(index),
            model: all.clone(),
            pose: settings.start_pose(index),
        })
        .collect();
    for (name, path) in models {
        let Some(name) = name else {
            continue;
        };
        let Some(robot) = robots.iter_mut().find(|robot| robot.name == *name) else {
            let last = robot_name(settings.robots.count - 1);
            return Err(InputError::new(
                format!("--robot {name}={}", path.display()),
                format!("there is no robot {name}"),
                format!("give r1 to {last}"),
            ));
        };
        robot.model = read_model(path)?;
    }
    Ok(robots)
}

/// Whether plant and controllers can be made of the robots: before anything is started.
fn judge(experiment: &Experiment, models: &[(Option<String>, PathBuf)]) -> Result<(), InputError> {
    let unusable = |name: Option<&str>, error: InputError| {
        // The plant's errors name the robot in front of the key.
        let (named, key) = match error.place.split_once(": ") {
            Some((named, key)) => (Some(named), key),
            None => (name, error.place.as_str()),
        };
        let own = models
            .iter()
            .find(|(name, _)| name.is_some() && name.as_deref() == named);
        let all = models.iter().find(|(name, _)| name.is_none());
        let place = match (own.or(all), experiment.settings.robots.model.as_str()) {
            (Some((_, path)), _) => path.display().to_string(),
            (None, "") => named.unwrap_or("robot").to_owned(),
            (None, path) => path.to_owned(),
        };
        InputError::new(place, format!("{key} {}", error.problem), error.remedy)
    };
    slipstream_sim::run::world(experiment).map_err(|error| unusable(None, error))?;
    for (index, robot) in (0..).zip(&experiment.robots) {
        Node::new(experiment, index).map_err(|error| unusable(Some(&robot.name), error))?;
    }
    Ok(())
}

fn read_model(path: &Path) -> Result<RobotModel, InputError> {
    robot_toml::read(path).map_err(|error| match error {
        slipstream_recording::Error::Input(unusable) => {
            let line = unusable
                .line
                .map(|line| format!(":{line}"))
                .unwrap_or_default();
            InputError::new(
                format!("{}{line}", unusable.path.display()),
                unusable.problem,
                unusable.remedy,
            )
        }
        other => InputError::new(
            path.display().to_string(),
            other.to_string(),
            "check the file",
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The files say what is assumed; what the code takes where nobody says anything is the same.
    #[test]
    fn the_papers_files_hold_the_defaults() {
        for (name, settings) in [
            ("platoon", Settings::default()),
            ("single", Settings::single()),
        ] {
            let request = Request {
                experiment: Some(name.to_owned()),
                ..Request::default()
            };
            let resolved = resolve(&request).unwrap();
            assert_eq!(resolved.experiment.settings, settings);
            assert!(resolved.assumptions.len() >= 3);
            for assumption in &resolved.assumptions {
                assert!(!assumption.keys.is_empty() && assumption.reason.len() > 40);
            }
            let text = resolved.to_toml();
            assert!(
                text.contains("; assumption friction") && text.contains("# assumption motor: ")
            );
            assert!(text.parse::<Table>().is_ok());
        }
    }
}
