//! What is watched: a bridge, a file that grows, or a recording that is replayed.

use std::path::Path;

use slipstream_live::source::{Bridge, Growing, Replay, Source};

use crate::exit::Error;
use crate::models::Models;
use crate::reading::Reading;

/// A source, and whether it goes on while nobody listens.
pub(super) struct Opened {
    pub(super) source: Box<dyn Source>,
    pub(super) is_live: bool,
}

/// Opens a source.
pub(super) fn open(
    name: &str,
    reading: &Reading,
    models: &Models,
    speed: Option<f64>,
) -> Result<Opened, Error> {
    let live = |source: Box<dyn Source>| Opened {
        source,
        is_live: true,
    };
    if name.starts_with("ws://") {
        let map = reading.topics()?;
        let bridge = Bridge::connect(name, map, models.wheel_joints())?;
        return Ok(live(Box::new(bridge)));
    }
    let path = Path::new(name);
    if Growing::grows(path) {
        let map = reading.topics()?;
        let growing = Growing::open(path, map, models.wheel_joints())?;
        return Ok(live(Box::new(growing)));
    }
    let recording = reading.read(path, models)?.recording;
    Ok(Opened {
        source: Box::new(Replay::new(name, recording, speed)),
        is_live: speed.is_some(),
    })
}
