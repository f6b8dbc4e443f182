//! Keys with provenance: settings as a TOML tree in which every key knows where its value came from.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use slipstream_bus::InputError;
use slipstream_bus::experiment::Settings;
use toml::{Table, Value};

use super::keys;
use super::request::{Assumption, Origin};

/// Names of the built-in experiments.
pub const BUILT_IN: [&str; 5] = ["platoon", "single", "circle", "figure_eight", "lane_change"];

/// Files of the experiments of the paper.
const PAPER_FILES: [(&str, &str); 2] = [
    ("platoon", include_str!("../../experiments/platoon.toml")),
    ("single", include_str!("../../experiments/single.toml")),
];

/// The keys of an experiment with the origin of each, while they are collected.
pub(super) struct KeyTree {
    table: Table,
    base: String,
    origins: BTreeMap<String, Origin>,
    /// Keys and reason, by name.
    assumptions: BTreeMap<String, (Vec<String>, String)>,
}

impl KeyTree {
    /// A built-in experiment; `None` if there is none of this name.
    pub(super) fn built_in(name: &str) -> Result<Option<Self>, InputError> {
        let Some(mut tree) = Self::plain(name) else {
            return Ok(None);
        };
        for (_, text) in PAPER_FILES.iter().filter(|(paper, _)| *paper == name) {
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
            assumptions: BTreeMap::new(),
        })
    }

    /// Adds the assumptions of a file.
    pub(super) fn assume(&mut self, file: &keys::File) -> Result<(), InputError> {
        for (name, keys, reason) in file.assumptions()? {
            if let Some(key) = keys
                .iter()
                .find(|key| keys::find(&self.table, key).is_none())
            {
                let place = file.place(&format!("assumptions.{name}.keys"));
                let remedy = self.suggest(key);
                return Err(InputError::new(
                    place,
                    format!("{key} is not a key"),
                    remedy,
                ));
            }
            self.assumptions.insert(name, (keys, reason));
        }
        Ok(())
    }

    pub(super) fn assumptions(&self) -> Vec<Assumption> {
        let value = |key: &String| keys::find(&self.table, key).map(ToString::to_string);
        let with_value = |key: &String| Some((key.clone(), value(key)?));
        let one = |(name, (keys, reason)): (&String, &(Vec<String>, String))| Assumption {
            name: name.clone(),
            keys: keys.iter().filter_map(with_value).collect(),
            reason: reason.clone(),
        };
        self.assumptions.iter().map(one).collect()
    }

    /// Sets one key. A value of the wrong type is refused with its origin.
    pub(super) fn set(
        &mut self,
        key: &str,
        value: Value,
        origin: &Origin,
    ) -> Result<(), InputError> {
        let place = || origin.to_string();
        let value = match keys::find(&self.table, key) {
            // Its type knows more forms than one.
            Some(_) if key == "links.topology" => value,
            Some(before) => keys::fit(before, value).map_err(|expected| {
                InputError::new(
                    place(),
                    format!("{key} is not a {expected}"),
                    format!("give a {expected}"),
                )
            })?,
            // A command is a text, whatever it looks like; the type of a parameter is its program's.
            None if key.starts_with("agents.") && keys::is_open(key) => match value {
                text @ Value::String(_) => text,
                other => Value::String(other.to_string()),
            },
            None if keys::is_open(key) => value,
            None => {
                let remedy = self.suggest(key);
                let problem = format!("{key} is not a key");
                return Err(InputError::new(place(), problem, remedy));
            }
        };
        let mut table = self.table.clone();
        keys::put(&mut table, key, value);
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
                "give a value of this type",
            )
        })?;
        self.table = table;
        self.origins.insert(key.to_owned(), origin.clone());
        Ok(())
    }

    pub(super) fn settings(&self) -> Result<Settings, InputError> {
        Settings::deserialize(self.table.clone())
            .map_err(|error| InputError::new(&self.base, error.message(), "correct the experiment"))
    }

    /// Remedy for a key that does not exist.
    fn suggest(&self, key: &str) -> String {
        match keys::nearest(&self.table, key) {
            Some(near) => format!("did you mean {near}? --dry-run lists all keys"),
            None => "--dry-run lists all keys".to_owned(),
        }
    }

    fn origin(&self, key: &str) -> Origin {
        let built_in = || Origin::BuiltIn(self.base.clone());
        self.origins.get(key).cloned().unwrap_or_else(built_in)
    }

    /// Place to name in an error about a key.
    pub(super) fn place_of(&self, key: &str) -> String {
        let inside = |other: &&String| other.starts_with(&format!("{key}."));
        match self.origins.keys().find(inside) {
            Some(inner) => self.origin(inner).to_string(),
            None => self.origin(key).to_string(),
        }
    }

    /// A path that a key names, relative to the file that sets the key.
    pub(super) fn path(&self, key: &str, named: &str) -> PathBuf {
        match self.origin(key) {
            Origin::File(file, _) => file.parent().unwrap_or(Path::new("")).join(named),
            _ => PathBuf::from(named),
        }
    }

    /// Every key with its value as TOML and its origin.
    pub(super) fn listing(&self) -> Vec<(String, String, Origin)> {
        keys::leaves(&self.table)
            .into_iter()
            .map(|(key, value)| {
                let origin = self.origin(&key);
                (key, value.to_string(), origin)
            })
            .collect()
    }
}
