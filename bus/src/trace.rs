//! Trace format: spans and events in postcard, in chunks that are decoded independently.
//!
//! A chunk is a sequence of [`Entry`]. What the records of one call site share (process, level and
//! names) is written once, before its first record. Times are differences to the previous record.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// First byte of every chunk in a file. Earlier formats begin with a smaller byte.
pub const FORMAT: u8 = 33;

/// A span or an event of the trace.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceRecord<'a> {
    /// When it began (ns).
    pub begin_ns: i64,
    /// The process: `plant`, a robot, `recorder` or `launcher`; across hosts `hosts` or `relay`; `run` for a run in one
    /// process.
    pub process: Cow<'a, str>,
    /// From 1 (error) to 5 (trace).
    pub level: u8,
    /// Name of the span or event.
    pub name: Cow<'a, str>,
    /// When the span closed (ns); `None` for an event.
    pub end_ns: Option<i64>,
    /// Names and values of its fields.
    pub fields: Vec<(Cow<'a, str>, Value<'a>)>,
}

/// The value of a field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Value<'a> {
    /// An integer.
    Int(i64),
    /// A floating-point number.
    Float(f64),
    /// A truth value.
    Bool(bool),
    /// Anything else, as text.
    Text(#[serde(borrow)] Cow<'a, str>),
}

/// Variant number of [`Value::Int`], for a writer that encodes it in parts.
pub const INT_TAG: u8 = 0;

/// An element of a chunk.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Entry<'a> {
    /// The next call site; the first has number 0.
    CallSite(#[serde(borrow)] CallSite<'a>),
    /// A record of an earlier call site of the chunk.
    Record(#[serde(borrow)] RecordData<'a>),
}

/// Variant number of [`Entry::CallSite`], for a writer that encodes it in parts.
pub const CALL_SITE_TAG: u32 = 0;
/// Variant number of [`Entry::Record`].
pub const RECORD_TAG: u8 = 1;

/// What all records of one call site share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CallSite<'a> {
    /// The process.
    #[serde(borrow)]
    pub process: Cow<'a, str>,
    /// From 1 (error) to 5 (trace).
    pub level: u8,
    /// Name of the span or event.
    #[serde(borrow)]
    pub name: Cow<'a, str>,
    /// Names of the fields.
    #[serde(borrow)]
    pub fields: Vec<Cow<'a, str>>,
}

/// The part of a record that is not shared with its call site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordData<'a> {
    /// Number of the call site in its chunk.
    pub call_site: u32,
    /// Begin since the begin of the previous record; of the first record, since time 0 (ns).
    pub since_previous_ns: i64,
    /// Duration of a span; `None` for an event (ns).
    pub duration_ns: Option<i64>,
    /// Field number at the call site, and value.
    #[serde(borrow)]
    pub fields: Vec<(u32, Value<'a>)>,
}

/// Why a chunk cannot be decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// It was written by another version of the program.
    #[error("its trace does not have format {FORMAT}, the one that this version reads")]
    OtherFormat,
    /// Its bytes do not decode.
    #[error("a record of its trace is damaged")]
    Damaged,
}

/// Decodes a chunk of a file, including its format byte, and calls `each` with every record.
///
/// # Errors
/// The chunk has another format, or is damaged.
pub fn read<'a>(chunk: &'a [u8], mut each: impl FnMut(TraceRecord<'a>)) -> Result<(), TraceError> {
    let mut rest = match chunk.split_first() {
        Some((&FORMAT, rest)) => rest,
        Some(_) => return Err(TraceError::OtherFormat),
        None => return Err(TraceError::Damaged),
    };
    let mut call_sites = Vec::new();
    let mut now_ns = 0_i64;
    while !rest.is_empty() {
        let (entry, after) = postcard::take_from_bytes(rest).map_err(|_| TraceError::Damaged)?;
        rest = after;
        match entry {
            Entry::CallSite(call_site) => call_sites.push(call_site),
            Entry::Record(data) => {
                now_ns = now_ns.wrapping_add(data.since_previous_ns);
                each(complete(&call_sites, now_ns, data).ok_or(TraceError::Damaged)?);
            }
        }
    }
    Ok(())
}

/// Joins a record with its call site; `None` if it names a call site or field that does not exist.
fn complete<'a>(
    call_sites: &[CallSite<'a>],
    begin_ns: i64,
    data: RecordData<'a>,
) -> Option<TraceRecord<'a>> {
    let call_site = call_sites.get(data.call_site as usize)?;
    let name = |at: u32| call_site.fields.get(at as usize).cloned();
    let fields = data.fields.into_iter();
    Some(TraceRecord {
        begin_ns,
        process: call_site.process.clone(),
        level: call_site.level,
        name: call_site.name.clone(),
        end_ns: data
            .duration_ns
            .map(|duration_ns| begin_ns.wrapping_add(duration_ns)),
        fields: fields
            .map(|(at, value)| Some((name(at)?, value)))
            .collect::<Option<_>>()?,
    })
}

impl<'a> TraceRecord<'a> {
    /// The value of a field.
    pub fn field(&self, name: &str) -> Option<&Value<'a>> {
        let found = self.fields.iter().find(|(field, _)| field == name);
        found.map(|(_, value)| value)
    }

    /// The value of an integer field.
    pub fn int(&self, name: &str) -> Option<i64> {
        match self.field(name) {
            Some(Value::Int(value)) => Some(*value),
            _ => None,
        }
    }

    /// The value of a text field.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.field(name) {
            Some(Value::Text(value)) => Some(value),
            _ => None,
        }
    }
}
