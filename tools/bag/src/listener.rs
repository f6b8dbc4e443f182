//! Whoever wants to have messages as they are written or read, as bytes.

use std::collections::BTreeMap;

/// A topic before its first message.
#[derive(Debug, Clone, Copy)]
pub struct Announced<'a> {
    /// Its name.
    pub topic: &'a str,
    /// Encoding of its messages, such as `cdr`.
    pub encoding: &'a str,
    /// Name of their type; empty if they have none.
    pub schema_name: &'a str,
    /// Encoding of the definition, such as `ros2msg`.
    pub schema_encoding: &'a str,
    /// The definition.
    pub schema: &'a [u8],
    /// Names and values: in files of slipstream's own, which stream it is.
    pub metadata: &'a BTreeMap<String, String>,
}

/// Has topics and messages, in their order.
pub trait Listener {
    /// A topic, before its messages. A topic may be announced again.
    fn announced(&mut self, channel: &Announced<'_>);

    /// A text that describes the recording: `recording.toml`, or `robot.toml` with the model.
    fn described(&mut self, _name: &str, _text: &str) {}

    /// A message with its log time (ns).
    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]);
}
