//! What a source is, and what it says.

use std::time::Duration;

use slipstream_bus::InputError;
use slipstream_recording::Recording;

/// What a source heard.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "most of what is heard are rows, and they are moved once"
)]
pub enum Heard {
    /// The new rows, of about half a second, with the description of the whole recording. Times have one origin over the whole
    /// session; rows of a stream are in the order of time, but a piece may begin before the end of the one before it, where
    /// clocks went back. A stream without new rows is empty.
    Rows(Recording),
    /// One line for the user: a guess, a connection that was lost, what is odd.
    Said(String),
    /// Nothing within the time.
    Nothing,
    /// There will be nothing more.
    End,
}

/// Whoever has the rows of a robot as it drives.
pub trait Source: Send {
    /// What it reads, as the user named it.
    fn name(&self) -> &str;

    /// What comes next, within `wait`.
    ///
    /// # Errors
    /// What the user has to correct; nothing follows.
    fn hear(&mut self, wait: Duration) -> Result<Heard, InputError>;
}
