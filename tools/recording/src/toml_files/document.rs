//! Strict reading of small TOML files: every error names file, line, key and remedy.

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::Unusable;

/// Largest TOML file that is read (bytes). Models and notes are a few kilobytes.
const LARGEST_BYTES: u64 = 4 << 20;

/// Reads a text file of bounded size.
pub(crate) fn read_text(path: &Path) -> Result<String, Unusable> {
    let size = std::fs::metadata(path).map_err(|e| Unusable::unreadable(path, &e))?;
    if size.len() > LARGEST_BYTES {
        return Err(Unusable::new(
            path,
            format!("has {} bytes, too many for a description", size.len()),
            "give the TOML file, not the data",
        ));
    }
    std::fs::read_to_string(path).map_err(|e| Unusable::unreadable(path, &e))
}

/// The text of one file and where it came from.
pub(crate) struct File<'a> {
    pub(crate) path: &'a Path,
    pub(crate) text: &'a str,
}

/// One table of a file, with the key that leads to it.
pub(crate) struct Section<'a> {
    file: &'a File<'a>,
    name: String,
    line: u64,
    pub(crate) table: &'a DeTable<'a>,
}

/// A key's value and its line.
pub(crate) struct Entry<'a> {
    file: &'a File<'a>,
    /// The whole key, such as `robot.wheel_radius_m`.
    pub(crate) key: String,
    line: u64,
    /// The value.
    pub(crate) value: &'a DeValue<'a>,
}

impl<'a> File<'a> {
    /// Parses the text.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'a>>, Unusable> {
        DeTable::parse(self.text).map_err(|error| {
            let line = error.span().map_or(1, |span| self.line(span.start));
            let problem = error.message().replace('\n', ", ");
            Unusable::new(self.path, problem, "write it as TOML").at(line)
        })
    }

    /// The whole file as a section.
    pub(crate) fn root(&'a self, table: &'a Spanned<DeTable<'a>>) -> Section<'a> {
        Section {
            file: self,
            name: String::new(),
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
    /// The whole key of `key` in this table.
    pub(crate) fn whole(&self, key: &str) -> String {
        if self.name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.name)
        }
    }

    /// An error about this table.
    pub(crate) fn error(&self, problem: impl Into<String>, remedy: impl Into<String>) -> Unusable {
        Unusable::new(self.file.path, problem, remedy).at(self.line)
    }

    /// All keys with their values, in the order of the file.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (&'a str, Entry<'a>)> {
        self.table.iter().map(|(key, value)| {
            let key: &'a Spanned<_> = key;
            let name: &'a str = key.get_ref();
            let entry = Entry {
                file: self.file,
                key: self.whole(name),
                line: self.file.line(key.span().start),
                value: value.get_ref(),
            };
            (name, entry)
        })
    }

    /// The value of `key`, if it is there.
    pub(crate) fn get(&self, key: &str) -> Option<Entry<'a>> {
        self.entries()
            .find(|(name, _)| *name == key)
            .map(|(_, entry)| entry)
    }

    /// The value of `key`, which must be there.
    pub(crate) fn require(&self, key: &str) -> Result<Entry<'a>, Unusable> {
        self.get(key).ok_or_else(|| {
            self.error(
                format!("{} is missing", self.whole(key)),
                format!("add `{key} = …`"),
            )
        })
    }

    /// The number at `key`, if it is there.
    pub(crate) fn number(&self, key: &str) -> Result<Option<f64>, Unusable> {
        self.get(key).map(|entry| entry.number()).transpose()
    }

    /// The table at `key`, if it is there.
    pub(crate) fn section(&self, key: &str) -> Result<Option<Section<'a>>, Unusable> {
        self.get(key).map(|entry| entry.section()).transpose()
    }

    /// Every key must be one of `known`.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), Unusable> {
        match self.entries().find(|(name, _)| !known.contains(name)) {
            None => Ok(()),
            Some((_, entry)) => Err(entry.error(
                "is no key of this table",
                format!("remove it or spell it as one of: {}", known.join(", ")),
            )),
        }
    }

    /// `format` must be there and 1.
    pub(crate) fn format_is_1(&self) -> Result<(), Unusable> {
        let entry = self.require("format")?;
        match entry.integer()? {
            1 => Ok(()),
            other => Err(entry.error(
                format!("is {other}"),
                "write `format = 1`, the only one this version reads",
            )),
        }
    }
}

impl<'a> Entry<'a> {
    /// An error about this key.
    pub(crate) fn error(&self, problem: impl AsRef<str>, remedy: impl Into<String>) -> Unusable {
        let problem = format!("{} {}", self.key, problem.as_ref());
        Unusable::new(self.file.path, problem, remedy).at(self.line)
    }

    /// A finite number, whole or not.
    pub(crate) fn number(&self) -> Result<f64, Unusable> {
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

    /// A whole number.
    pub(crate) fn integer(&self) -> Result<i64, Unusable> {
        match self.value {
            DeValue::Integer(whole) => i64::from_str_radix(whole.as_str(), whole.radix())
                .map_err(|_| self.error("is out of range", "give a smaller whole number")),
            _ => Err(self.wrong_type("a whole number")),
        }
    }

    /// A number of counts in a turn.
    pub(crate) fn counts(&self) -> Result<u32, Unusable> {
        match u32::try_from(self.integer()?) {
            Ok(counts) if counts > 0 => Ok(counts),
            _ => Err(self.error(
                "is no number of counts",
                "give the counts in one turn of the wheel, a whole number above 0",
            )),
        }
    }

    /// A text.
    pub(crate) fn text(&self) -> Result<&'a str, Unusable> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a text"))
    }

    /// True or false.
    pub(crate) fn boolean(&self) -> Result<bool, Unusable> {
        self.value
            .as_bool()
            .ok_or_else(|| self.wrong_type("true or false"))
    }

    /// A table.
    pub(crate) fn section(&self) -> Result<Section<'a>, Unusable> {
        let table = self
            .value
            .as_table()
            .ok_or_else(|| self.wrong_type("a table"))?;
        Ok(Section {
            file: self.file,
            name: self.key.clone(),
            line: self.line,
            table,
        })
    }

    /// The elements of a list, or the value alone where it is none.
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

    /// The value is of a wrong type.
    pub(crate) fn wrong_type(&self, wanted: &str) -> Unusable {
        self.error(
            format!("is a {}", self.value.type_str()),
            format!("give {wanted}"),
        )
    }
}
