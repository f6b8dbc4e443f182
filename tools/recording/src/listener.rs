//! Whoever wants to have messages as they are written or read, as bytes.

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
}

/// Has topics and messages, in their order.
pub trait Listener {
    /// A topic, before its messages. A topic may be announced again.
    fn announced(&mut self, channel: &Announced<'_>);

    /// A message with its log time (ns).
    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]);
}
