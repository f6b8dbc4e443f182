//! What is known about a run before it begins; written at the start of the file.

use std::collections::BTreeMap;

use slipstream_bus::experiment::{Drive, WheelSource};

use crate::recording::Recording;

/// What is known about a run before it begins.
#[derive(Debug, Clone, Default)]
pub struct RunHeader {
    /// The robots in order, with their encoders and noise, and the nominal model. Streams are ignored.
    pub description: Recording,
    /// Files to attach, such as the experiment and the models of single robots.
    pub attachments: Vec<Attachment>,
    /// What robots are told.
    pub drive: Drive,
    /// Where what the wheels of each robot do is known from. Robots without an entry are simulated.
    pub wheels: Vec<WheelSource>,
    /// Further names and values, such as versions and the seed.
    pub metadata: BTreeMap<String, String>,
}

/// A file attached to a run.
#[derive(Debug, Clone)]
pub struct Attachment {
    /// File name, such as `experiment.toml`.
    pub name: String,
    /// Media type, such as `application/toml`.
    pub media_type: String,
    /// Content.
    pub data: Vec<u8>,
}
