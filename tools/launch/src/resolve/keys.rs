//! Dotted keys in TOML tables, and the lines at which a file sets them.
//!
//! figment merges sources with provenance too, but does not know the line of a key in its file.

use std::path::{Path, PathBuf};

use slipstream_bus::InputError;
use strsim::levenshtein;
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

/// A file with an experiment.
#[derive(Debug)]
pub(crate) struct File {
    path: PathBuf,
    table: Table,
    /// Keys in the order of the file, with their lines.
    lines: Vec<(String, usize)>,
}

/// Keys of a file that belong to the format, not to the experiment.
const FORMAT_KEYS: [&str; 2] = ["format", "base"];
/// Name of the table of assumptions.
const ASSUMPTIONS: &str = "assumptions";

impl File {
    /// Parses the text of an experiment.
    pub(crate) fn parse(path: &Path, text: &str) -> Result<Self, InputError> {
        let invalid = |error: toml::de::Error| {
            let line = error.span().map_or(1, |span| line_at(text, span.start));
            let problem = error
                .message()
                .lines()
                .next()
                .unwrap_or_default()
                .to_owned();
            let problem = format!("is not valid TOML: {problem}");
            InputError::file(path, problem, "correct the line").at(line as u64)
        };
        let table: Table = text.parse().map_err(invalid)?;
        let spanned = DeTable::parse(text).map_err(invalid)?;
        let mut lines = Vec::new();
        gather(spanned.get_ref(), "", text, &mut lines);
        lines.sort_by_key(|&(_, line)| line);
        let file = Self {
            path: path.to_owned(),
            table,
            lines,
        };
        match file.table.get("format") {
            None | Some(Value::Integer(1)) => Ok(file),
            Some(other) => Err(InputError::new(
                file.place("format"),
                format!("format is {other}"),
                "give format = 1, the only one that this version reads",
            )),
        }
    }

    /// The built-in experiment that the file names as its base.
    pub(crate) fn base(&self) -> Option<String> {
        let base = self.table.get("base")?;
        Some(
            base.as_str()
                .map_or_else(|| base.to_string(), str::to_owned),
        )
    }

    /// Assumptions of the file: name, keys and reason, in order of the names.
    pub(crate) fn assumptions(&self) -> Result<Vec<(String, Vec<String>, String)>, InputError> {
        let Some(table) = self.table.get(ASSUMPTIONS).and_then(Value::as_table) else {
            return Ok(Vec::new());
        };
        let read = |(name, value): (&String, &Value)| {
            let AssumptionEntry { keys, reason } = value.clone().try_into().map_err(|_| {
                let first = self
                    .lines
                    .iter()
                    .find(|(key, _)| key.starts_with(&format!("{ASSUMPTIONS}.{name}.")));
                let line = first.map_or(1, |&(_, line)| line);
                let place = format!("{}:{line}", self.path.display());
                let problem = format!("{ASSUMPTIONS}.{name} is not an assumption");
                InputError::new(
                    place,
                    problem,
                    "give it keys = [\"KEY\", …] and a reason = \"…\"",
                )
            })?;
            Ok((name.clone(), keys, reason))
        };
        table.iter().map(read).collect()
    }

    /// File and line of a key.
    pub(crate) fn place(&self, key: &str) -> String {
        let line = self
            .lines
            .iter()
            .find(|(name, _)| name == key)
            .map_or(1, |&(_, line)| line);
        format!("{}:{line}", self.path.display())
    }

    /// Keys of the experiment with values and lines, in the order of the file.
    pub(crate) fn keys(&self) -> Vec<(String, Value, usize)> {
        let own = self
            .lines
            .iter()
            .filter(|(key, _)| !FORMAT_KEYS.contains(&key.as_str()) && !is_assumption(key));
        own.filter_map(|(key, line)| {
            find(&self.table, key).map(|value| (key.clone(), value.clone(), *line))
        })
        .collect()
    }
}

/// An assumption in a file.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct AssumptionEntry {
    keys: Vec<String>,
    reason: String,
}

fn is_assumption(key: &str) -> bool {
    key.split('.').next() == Some(ASSUMPTIONS)
}

fn gather(table: &DeTable<'_>, prefix: &str, text: &str, lines: &mut Vec<(String, usize)>) {
    for (key, value) in table {
        let name = format!("{prefix}{}", key.get_ref());
        match value.get_ref() {
            DeValue::Table(inner) => gather(inner, &format!("{name}."), text, lines),
            _ => lines.push((name, line_at(text, key.span().start))),
        }
    }
}

fn line_at(text: &str, offset: usize) -> usize {
    let before = text.get(..offset).unwrap_or(text);
    before.bytes().filter(|&byte| byte == b'\n').count() + 1
}

/// The value of a dotted key, unless it is a table.
pub(crate) fn find<'a>(table: &'a Table, key: &str) -> Option<&'a Value> {
    match key.split_once('.') {
        None => table.get(key).filter(|value| !value.is_table()),
        Some((first, rest)) => find(table.get(first)?.as_table()?, rest),
    }
}

/// Whether a key is one of those whose names the user chooses: `agents.NAME`, `controller.NAME.PARAMETER`.
pub(crate) fn is_open(key: &str) -> bool {
    let parts: Vec<&str> = key.split('.').collect();
    let named = !parts.iter().any(|part| part.is_empty());
    named && matches!(parts.as_slice(), ["agents", _] | ["controller", _, _])
}

/// Sets the value of a dotted key.
pub(crate) fn put(table: &mut Table, key: &str, value: Value) {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value);
        }
        Some((first, rest)) => {
            let inner = table.entry(first).or_insert(Value::Table(Table::new()));
            if let Value::Table(inner) = inner {
                put(inner, rest, value);
            }
        }
    }
}

/// All dotted keys with their values, in order.
pub(crate) fn leaves(table: &Table) -> Vec<(String, &Value)> {
    let mut found = Vec::new();
    for (key, value) in table {
        match value {
            Value::Table(inner) => {
                let inner = leaves(inner).into_iter();
                found.extend(inner.map(|(rest, value)| (format!("{key}.{rest}"), value)));
            }
            _ => found.push((key.clone(), value)),
        }
    }
    found
}

/// The key closest to a misspelt one by Levenshtein distance (of the whole key, or of its last part
/// plus 1), if that is at most 3.
pub(crate) fn nearest(table: &Table, key: &str) -> Option<String> {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let distance = |candidate: &str| {
        levenshtein(candidate, key).min(levenshtein(&last(candidate), &last(key)) + 1)
    };
    leaves(table)
        .into_iter()
        .map(|(candidate, _)| (distance(&candidate), candidate))
        .min()
        .filter(|&(distance, _)| distance <= 3)
        .map(|(_, candidate)| candidate)
}

/// Converts a value to the type of `before`; integers become floats.
///
/// # Errors
/// The name of the type that is needed.
pub(crate) fn fit(before: &Value, value: Value) -> Result<Value, &'static str> {
    #[expect(
        clippy::cast_precision_loss,
        reason = "a key given as a whole number is small"
    )]
    let float = |value: Value| match value {
        Value::Integer(whole) => Value::Float(whole as f64),
        other => other,
    };
    let value = match (before, value) {
        (Value::Float(_), value) => float(value),
        (Value::Array(_), Value::Array(items)) => {
            Value::Array(items.into_iter().map(float).collect())
        }
        (Value::Integer(_), Value::Integer(whole)) if whole < 0 => {
            return Err("whole number, 0 or more");
        }
        (Value::String(_), value @ (Value::Boolean(_) | Value::Integer(_) | Value::Float(_))) => {
            Value::String(value.to_string())
        }
        (_, value) => value,
    };
    if before.same_type(&value) {
        return Ok(value);
    }
    Err(match before {
        Value::String(_) => "text",
        Value::Integer(_) => "whole number",
        Value::Float(_) => "number",
        Value::Boolean(_) => "true or false",
        Value::Array(_) => "list",
        Value::Datetime(_) | Value::Table(_) => "table",
    })
}

/// Parses a command-line value: TOML, else text.
pub(crate) fn parse_value(text: &str) -> Value {
    let parsed = format!("value = {text}").parse::<Table>().ok();
    let value = parsed
        .filter(|table| table.len() == 1)
        .and_then(|mut t| t.remove("value"));
    value.unwrap_or_else(|| Value::String(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_on_a_command_line_are_toml_or_text() {
        assert_eq!(parse_value("0.1"), Value::Float(0.1));
        assert_eq!(parse_value("ring"), Value::String("ring".into()));
        assert_eq!(parse_value("a.csv"), Value::String("a.csv".into()));
        assert_eq!(parse_value("1\nb = 2"), Value::String("1\nb = 2".into()));
    }

    #[test]
    fn a_misspelt_key_is_recognised() {
        let table: Table = "[links]\ndelay_s = 1\n[control]\nk_x = 2".parse().unwrap();
        assert_eq!(
            nearest(&table, "links.dealy_s").as_deref(),
            Some("links.delay_s")
        );
        assert_eq!(
            nearest(&table, "link.delay_s").as_deref(),
            Some("links.delay_s")
        );
        assert_eq!(nearest(&table, "weather"), None);
    }
}
