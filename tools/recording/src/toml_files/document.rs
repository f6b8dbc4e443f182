//! Strict reader of small TOML files: every error names file, line, key and remedy.

use std::path::Path;

use slipstream_bus::{Encoder, InputError};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A TOML string.
pub(crate) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// The text of a file.
pub(crate) struct TomlFile<'a> {
    /// Path of the file, for errors.
    pub(crate) path: &'a Path,
    /// Its text.
    pub(crate) text: &'a str,
}

/// A table of a file.
pub(crate) struct Section<'a> {
    file: &'a TomlFile<'a>,
    /// Full key of the table; empty for the root.
    key: String,
    line: u64,
    table: &'a DeTable<'a>,
}

/// A key with its value and its line.
pub(crate) struct Entry<'a> {
    file: &'a TomlFile<'a>,
    /// The full key, such as `robot.wheel_radius_m`.
    pub(crate) key: String,
    line: u64,
    /// The value.
    pub(crate) value: &'a DeValue<'a>,
}

impl<'a> TomlFile<'a> {
    /// Parses the text.
    ///
    /// # Errors
    /// If it is not TOML, with the line.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'a>>, InputError> {
        DeTable::parse(self.text).map_err(|error| {
            let line = error.span().map_or(1, |span| self.line(span.start));
            let problem = error.message().replace('\n', ", ");
            InputError::file(self.path, problem, "correct the TOML syntax").at(line)
        })
    }

    /// The root table.
    pub(crate) fn root(&'a self, table: &'a Spanned<DeTable<'a>>) -> Section<'a> {
        Section {
            file: self,
            key: String::new(),
            line: 1,
            table: table.get_ref(),
        }
    }

    fn line(&self, offset: usize) -> u64 {
        let before = self.text.as_bytes().iter().take(offset);
        1 + before.filter(|&&byte| byte == b'\n').count() as u64
    }
}

impl<'a> Section<'a> {
    /// The full key of `key` in this table.
    fn full_key(&self, key: &str) -> String {
        if self.key.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.key)
        }
    }

    /// An error about this table.
    pub(crate) fn error(
        &self,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InputError {
        InputError::file(self.file.path, problem, remedy).at(self.line)
    }

    /// Whether the robot's pose is that of its centre of mass (`pose_point`), and not that of the axle's middle.
    ///
    /// # Errors
    /// If the point is neither.
    pub(crate) fn is_pose_of_mass(&self) -> Result<bool, InputError> {
        let Some(point) = self.get("pose_point") else {
            return Ok(false);
        };
        match point.text()? {
            "axle" => Ok(false),
            "centre_of_mass" => Ok(true),
            _ => {
                let remedy = "write \"axle\" or \"centre_of_mass\"";
                Err(point.error("is not valid", remedy))
            }
        }
    }

    /// An error about a dotted key below this table, at the line of the deepest part of it that
    /// the file has.
    pub(crate) fn error_below(&self, error: &InputError) -> InputError {
        let problem = format!("{} {}", error.place, error.problem);
        InputError::file(self.file.path, problem, &error.remedy).at(self.line_of(&error.place))
    }

    fn line_of(&self, key: &str) -> u64 {
        let (first, rest) = key.split_once('.').unwrap_or((key, ""));
        self.get(first).map_or(self.line, |entry| {
            let section = entry.section();
            section.map_or(entry.line, |section| section.line_of(rest))
        })
    }

    /// All keys with their values, in file order.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (&'a str, Entry<'a>)> {
        self.table.iter().map(|(key, value)| {
            let key: &'a Spanned<_> = key;
            let name: &'a str = key.get_ref();
            let entry = Entry {
                file: self.file,
                key: self.full_key(name),
                line: self.file.line(key.span().start),
                value: value.get_ref(),
            };
            (name, entry)
        })
    }

    /// The entry of `key`, if present.
    pub(crate) fn get(&self, key: &str) -> Option<Entry<'a>> {
        self.entries()
            .find(|(name, _)| *name == key)
            .map(|(_, entry)| entry)
    }

    /// The entry of `key`.
    ///
    /// # Errors
    /// If it is missing.
    pub(crate) fn require(&self, key: &str) -> Result<Entry<'a>, InputError> {
        self.get(key).ok_or_else(|| {
            self.error(
                format!("{} is missing", self.full_key(key)),
                format!("add `{key} = …`"),
            )
        })
    }

    /// The number at `key`, if present.
    ///
    /// # Errors
    /// If the value is not a finite number.
    pub(crate) fn number(&self, key: &str) -> Result<Option<f64>, InputError> {
        self.get(key).map(|entry| entry.number()).transpose()
    }

    /// The table at `key`, if present.
    ///
    /// # Errors
    /// If the value is not a table.
    pub(crate) fn section(&self, key: &str) -> Result<Option<Section<'a>>, InputError> {
        self.get(key).map(|entry| entry.section()).transpose()
    }

    /// Checks that the table has no other keys than `known`.
    ///
    /// # Errors
    /// The first other key.
    pub(crate) fn allow_only(&self, known: &[&str]) -> Result<(), InputError> {
        match self.entries().find(|(name, _)| !known.contains(name)) {
            None => Ok(()),
            Some((_, entry)) => Err(entry.error(
                "is not a key of this table",
                format!("remove it or write one of: {}", known.join(", ")),
            )),
        }
    }

    /// Checks the key `format`.
    ///
    /// # Errors
    /// If it is missing or not 1.
    pub(crate) fn require_format_1(&self) -> Result<(), InputError> {
        let entry = self.require("format")?;
        match entry.integer()? {
            1 => Ok(()),
            other => Err(entry.error(
                format!("is {other}"),
                "write `format = 1`, the only format that this version reads",
            )),
        }
    }
}

impl<'a> Entry<'a> {
    /// An error about this key.
    pub(crate) fn error(&self, problem: impl AsRef<str>, remedy: impl Into<String>) -> InputError {
        let problem = format!("{} {}", self.key, problem.as_ref());
        InputError::file(self.file.path, problem, remedy).at(self.line)
    }

    /// The value as a number.
    ///
    /// # Errors
    /// If it is not a finite number.
    pub(crate) fn number(&self) -> Result<f64, InputError> {
        let number = match self.value {
            DeValue::Integer(whole) => i64::from_str_radix(whole.as_str(), whole.radix())
                .ok()
                .map(|whole| whole as f64),
            DeValue::Float(float) => float.as_str().parse().ok(),
            _ => return Err(self.wrong_type("a number")),
        };
        match number {
            Some(number) if number.is_finite() => Ok(number),
            _ => Err(self.error("is not finite", "give a finite number")),
        }
    }

    /// The value as a whole number.
    ///
    /// # Errors
    /// If it is not a whole number of 64 bits.
    pub(crate) fn integer(&self) -> Result<i64, InputError> {
        match self.value {
            DeValue::Integer(whole) => i64::from_str_radix(whole.as_str(), whole.radix())
                .map_err(|_| self.error("is out of range", "give a smaller whole number")),
            _ => Err(self.wrong_type("a whole number")),
        }
    }

    /// The value as encoder counts per revolution.
    ///
    /// # Errors
    /// If it is no number from 1 on.
    pub(crate) fn counts_per_rev(&self) -> Result<f64, InputError> {
        let counts = self.number()?;
        match Encoder::COUNTS.contains(&counts) {
            true => Ok(counts),
            false => Err(self.error(
                "is not a valid number of counts",
                "give the counts per wheel revolution, a number from 1 on",
            )),
        }
    }

    /// The value as a string.
    ///
    /// # Errors
    /// If it is not a string.
    pub(crate) fn text(&self) -> Result<&'a str, InputError> {
        self.value
            .as_str()
            .ok_or_else(|| self.wrong_type("a string"))
    }

    /// The value as a boolean.
    ///
    /// # Errors
    /// If it is not a boolean.
    pub(crate) fn boolean(&self) -> Result<bool, InputError> {
        self.value
            .as_bool()
            .ok_or_else(|| self.wrong_type("true or false"))
    }

    /// The value as a table.
    ///
    /// # Errors
    /// If it is not a table.
    pub(crate) fn section(&self) -> Result<Section<'a>, InputError> {
        let table = self
            .value
            .as_table()
            .ok_or_else(|| self.wrong_type("a table"))?;
        Ok(Section {
            file: self.file,
            key: self.key.clone(),
            line: self.line,
            table,
        })
    }

    /// The elements of an array; for any other value, the value itself.
    pub(crate) fn elements(&self) -> Vec<Entry<'a>> {
        let element = |key, value| Entry {
            file: self.file,
            key,
            line: self.line,
            value,
        };
        match self.value.as_array() {
            None => vec![element(self.key.clone(), self.value)],
            Some(list) => list
                .iter()
                .enumerate()
                .map(|(i, value)| element(format!("{}[{i}]", self.key), value.get_ref()))
                .collect(),
        }
    }

    /// An error about the type of the value.
    pub(crate) fn wrong_type(&self, expected: &str) -> InputError {
        let found = self.value.type_str();
        let article = if found.starts_with(['a', 'i']) {
            "an"
        } else {
            "a"
        };
        self.error(format!("is {article} {found}"), format!("give {expected}"))
    }
}
/// Counts per revolution as a value of TOML: without a point where there is no fraction.
pub(crate) fn counts_value(counts_per_rev: f64) -> toml::Value {
    match counts_per_rev.fract() == 0.0 {
        true => toml::Value::Integer(counts_per_rev as i64),
        false => toml::Value::Float(counts_per_rev),
    }
}
