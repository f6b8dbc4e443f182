//! Encoder for the fields of a span or an event.

use std::borrow::Cow;
use std::fmt::{Debug, Write as _};

use tracing::field::{Field, Visit};

use slipstream_bus::trace::{INT_TAG, Value};

use super::varint;

/// Longer texts are truncated (bytes).
pub(super) const MAX_TEXT: usize = 512;

/// Fields, encoded one after the other.
#[derive(Debug, Default)]
pub(super) struct Fields {
    pub(super) bytes: Vec<u8>,
    pub(super) count: u32,
    /// Value of the field `t_ns`: when the event happened (ns).
    pub(super) t_ns: Option<i64>,
    text: String,
}

impl Fields {
    pub(super) fn clear(&mut self) {
        self.bytes.clear();
        self.count = 0;
        self.t_ns = None;
    }

    fn put(&mut self, field: &Field, value: &Value<'_>) {
        // Writing to memory cannot fail.
        let _ = postcard::to_io(&(field.index() as u32, value), &mut self.bytes);
        self.count += 1;
    }

    /// Like `put` for a [`Value::Int`], the most common case.
    fn put_int(&mut self, field: &Field, value: i64) {
        varint::unsigned(field.index() as u64, &mut self.bytes);
        self.bytes.push(INT_TAG);
        varint::signed(value, &mut self.bytes);
        self.count += 1;
    }
}

impl Visit for Fields {
    fn record_i64(&mut self, field: &Field, value: i64) {
        if field.name() == "t_ns" {
            self.t_ns = Some(value);
        }
        self.put_int(field, value);
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.put_int(field, i64::try_from(value).unwrap_or(i64::MAX));
    }

    fn record_f64(&mut self, field: &Field, value: f64) {
        self.put(field, &Value::Float(value));
    }

    fn record_bool(&mut self, field: &Field, value: bool) {
        self.put(field, &Value::Bool(value));
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        let value = &value[..value.floor_char_boundary(MAX_TEXT)];
        self.put(field, &Value::Text(Cow::Borrowed(value)));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        // Writing to a string fails only where `value` does.
        let _ = write!(text, "{value:?}");
        self.record_str(field, &text);
        self.text = text;
    }
}
