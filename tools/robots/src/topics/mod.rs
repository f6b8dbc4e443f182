//! Topics: messages that are published and heard, whatever carries them.

mod carrier;
mod names;
#[cfg(feature = "zenoh")]
mod zenoh;

#[cfg(not(feature = "zenoh"))]
use slipstream_bus::transport::BusError;

pub use self::carrier::{Heard, Opening, Topics};
pub use self::names::{MessageType, Topic};
#[cfg(feature = "zenoh")]
pub use self::zenoh::open;

/// Whether this build has a network.
pub const IS_BUILT: bool = cfg!(feature = "zenoh");

/// Why this build cannot do it, as the second part of a sentence, and what to do.
pub const NOT_BUILT: [&str; 2] = [
    "this build has no network",
    "build slipstream with --features hosts",
];

/// Opens topics.
///
/// # Errors
/// Always, in this build.
#[cfg(not(feature = "zenoh"))]
pub fn open(_: &Opening<'_>) -> Result<Box<dyn Topics>, BusError> {
    let [problem, remedy] = NOT_BUILT;
    Err(BusError::Failed {
        what: "robots".to_owned(),
        reason: format!("{problem}; {remedy}"),
    })
}
