//! Texts that people write: TOML files, arguments, measured round trips.

use std::path::Path;

use slipstream_bus::InputError;
use slipstream_launch::{Request, Resolved, resolve};
use slipstream_recording::{TopicMap, recording_toml, robot_toml};

use crate::one_line::assert_one_line;
use crate::runs::short_run;
use crate::scratch;

/// A `recording.toml`.
pub(crate) fn recording_toml(bytes: &[u8]) {
    let path = Path::new("recording.toml");
    let parse = |text: &str| recording_toml::parse(text, path, "fuzz");
    round_trip(bytes, parse, recording_toml::to_text);
}

/// A `robot.toml`.
pub(crate) fn robot_toml(bytes: &[u8]) {
    let parse = |text: &str| robot_toml::parse(text, Path::new("robot.toml"));
    round_trip(bytes, parse, robot_toml::to_text);
}

/// A topic map.
pub(crate) fn topic_map(bytes: &[u8]) {
    let parse = |text: &str| TopicMap::parse(text, Path::new("map.toml"));
    round_trip(bytes, parse, TopicMap::to_text);
}

/// Parses a text; what was accepted and written can be read, and is then written as the same text.
fn round_trip<T>(
    bytes: &[u8],
    parse: impl Fn(&str) -> Result<T, InputError>,
    to_text: impl Fn(&T) -> String,
) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match parse(text) {
        Ok(value) => {
            let written = to_text(&value);
            let again = parse(&written).expect("what was written can be read");
            assert_eq!(to_text(&again), written);
        }
        Err(error) => assert_one_line(&error),
    }
}

/// An experiment file. A text with a slash could name a file outside of the scratch folder.
pub(crate) fn experiment_file(bytes: &[u8]) {
    if !bytes.contains(&b'/') {
        resolved(&of_file(bytes));
    }
}

/// The request for an experiment file of this content.
fn of_file(content: &[u8]) -> Request {
    let path = scratch::file("fuzz.toml", content);
    Request {
        experiment: Some(path.display().to_string()),
        ..Request::default()
    }
}

/// Arguments `--set KEY=VALUE`, one a line.
pub(crate) fn set_arguments(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    if text.contains('/') {
        return;
    }
    let pairs = text.lines().filter_map(|line| line.split_once('='));
    let resolved = resolved(&Request {
        set: pairs
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect(),
        ..Request::default()
    });
    if let Some(resolved) = resolved {
        short_run(resolved.experiment);
    }
}

/// Resolves a request; the listing of its keys is a file of the same experiment.
fn resolved(request: &Request) -> Option<Resolved> {
    let resolved = match resolve(request) {
        Ok(resolved) => resolved,
        Err(error) => {
            assert_one_line(&error);
            return None;
        }
    };
    let again = resolve(&of_file(resolved.to_toml().as_bytes())).expect("the listing can be read");
    assert_eq!(again.experiment, resolved.experiment);
    Some(resolved)
}

/// A file of measured round trips.
pub(crate) fn round_trips(bytes: &[u8]) {
    let path = scratch::file("rtt.csv", bytes);
    let request = Request {
        set: vec![("links.trace".to_owned(), path.display().to_string())],
        ..Request::default()
    };
    match resolve(&request) {
        Ok(resolved) => {
            let experiment = &resolved.experiment;
            let negative = |half: &&i64| **half < 0;
            let delays = &experiment.half_round_trips_ns;
            assert!(!delays.is_empty());
            assert!(delays.iter().flatten().find(negative).is_none());
            let longest_ns = experiment.longest_trace_ns();
            assert!(experiment.settings.expected_token_round_ns(longest_ns) > 0);
        }
        Err(error) => assert_one_line(&error),
    }
}
