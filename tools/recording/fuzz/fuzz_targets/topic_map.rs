//! Any text as a topic map: an error, or a map that round-trips.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use slipstream_recording::TopicMap;

fuzz_target!(|text: &str| {
    let path = Path::new("map.toml");
    if let Ok(map) = TopicMap::parse(text, path) {
        let written = map.to_text();
        let again = TopicMap::parse(&written, path).expect("what was written can be read");
        assert_eq!(again.to_text(), written);
    }
});
