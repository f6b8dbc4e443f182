//! How the trace lies in a recording: pieces that are read each by itself.
//!
//! A piece is postcard: [`Entry`] after entry. What all records of one kind have in common, the names,
//! stands once, before the first of them; times are told as what lies between them.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::FORMAT;

/// A record of the trace.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced<'a> {
    /// When it began (ns).
    pub begin_ns: i64,
    /// Who told it: `plant`, a robot, `recorder`, `launcher`, or `run` where all is one process.
    pub process: Cow<'a, str>,
    /// From 1 (error) to 5 (trace).
    pub level: u8,
    /// The span's or event's name.
    pub name: Cow<'a, str>,
    /// When it closed (ns); none for an event.
    pub end_ns: Option<i64>,
    /// What else it says.
    pub fields: Vec<(Cow<'a, str>, Value<'a>)>,
}

/// The value of a field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Value<'a> {
    /// A whole number.
    Int(i64),
    /// A number.
    Float(f64),
    /// Yes or no.
    Bool(bool),
    /// Anything else.
    Text(#[serde(borrow)] Cow<'a, str>),
}

/// The place of [`Value::Int`] among the values, for who writes it in parts.
pub(super) const INT: u8 = 0;

/// What a piece is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) enum Entry<'a> {
    /// The next kind of records. The first is 0.
    Kind(#[serde(borrow)] Kind<'a>),
    /// A record of a kind that stands before.
    Told(#[serde(borrow)] Told<'a>),
}

/// The place of [`Entry::Kind`] among the entries, for who writes it in parts.
pub(super) const KIND: u32 = 0;
/// The place of [`Entry::Told`].
pub(super) const TOLD: u8 = 1;

/// What records of one place in the program have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Kind<'a> {
    #[serde(borrow)]
    pub(super) process: Cow<'a, str>,
    pub(super) level: u8,
    #[serde(borrow)]
    pub(super) name: Cow<'a, str>,
    #[serde(borrow)]
    pub(super) fields: Vec<Cow<'a, str>>,
}

/// What is a record's own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Told<'a> {
    pub(super) kind: u32,
    /// From the beginning of the record before, or from zero (ns).
    pub(super) after_ns: i64,
    /// From beginning to closing (ns); none for an event.
    pub(super) took_ns: Option<i64>,
    /// Which field of the kind, and its value.
    #[serde(borrow)]
    pub(super) fields: Vec<(u32, Value<'a>)>,
}

/// Why a trace record cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TracedError {
    /// It is of another program version.
    #[error("its trace is of another format than {FORMAT}, the one that this program reads")]
    OtherFormat,
    /// It is damaged.
    #[error("a record of its trace is damaged")]
    Damaged,
}

/// Shows `each` the records of a piece of a trace as it stands in a file.
///
/// # Errors
/// A piece of another format, or a damaged one.
pub fn read<'a>(piece: &'a [u8], mut each: impl FnMut(Traced<'a>)) -> Result<(), TracedError> {
    let mut rest = match piece.split_first() {
        Some((&FORMAT, rest)) => rest,
        Some(_) => return Err(TracedError::OtherFormat),
        None => return Err(TracedError::Damaged),
    };
    let mut kinds = Vec::new();
    let mut now_ns = 0_i64;
    while !rest.is_empty() {
        let (entry, after) = postcard::take_from_bytes(rest).map_err(|_| TracedError::Damaged)?;
        rest = after;
        match entry {
            Entry::Kind(kind) => kinds.push(kind),
            Entry::Told(told) => {
                now_ns = now_ns.wrapping_add(told.after_ns);
                each(whole(&kinds, now_ns, told).ok_or(TracedError::Damaged)?);
            }
        }
    }
    Ok(())
}

/// A record with what its kind says.
fn whole<'a>(kinds: &[Kind<'a>], begin_ns: i64, told: Told<'a>) -> Option<Traced<'a>> {
    let kind = kinds.get(told.kind as usize)?;
    let name = |at: u32| kind.fields.get(at as usize).cloned();
    let fields = told.fields.into_iter();
    Some(Traced {
        begin_ns,
        process: kind.process.clone(),
        level: kind.level,
        name: kind.name.clone(),
        end_ns: told.took_ns.map(|took_ns| begin_ns.wrapping_add(took_ns)),
        fields: fields
            .map(|(at, value)| Some((name(at)?, value)))
            .collect::<Option<_>>()?,
    })
}

impl<'a> Traced<'a> {
    /// The value of a field.
    pub fn field(&self, name: &str) -> Option<&Value<'a>> {
        let found = self.fields.iter().find(|(field, _)| field == name);
        found.map(|(_, value)| value)
    }

    /// The value of a field that is a whole number.
    pub fn int(&self, name: &str) -> Option<i64> {
        match self.field(name) {
            Some(Value::Int(value)) => Some(*value),
            _ => None,
        }
    }

    /// The value of a field that is text.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.field(name) {
            Some(Value::Text(value)) => Some(value),
            _ => None,
        }
    }
}
