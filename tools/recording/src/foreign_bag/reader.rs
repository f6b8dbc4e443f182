//! Reader of ROS 2 bags (MCAP) of other robots.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use slipstream_bus::InputError;

use super::guess::guess;
use super::survey::{Open, Topic, scan, survey};
use super::topic_map::TopicMap;
use crate::bag::{Item, VisitResult};
use crate::decode::StreamBuilder;
use crate::error::Result;
use crate::import::Spooled;
use crate::recording::Recording;
use crate::ros2::time::s_from_ns;
use crate::rows::{Disk, SpooledRecording};

/// Reads a bag of another robot. Without a map, one is guessed and given in the warnings, so that
/// the user can save and correct it. Times count from the first message of the mapped topics.
///
/// # Errors
/// If it is not an MCAP file, if a topic of the map does not exist or cannot provide its stream, or
/// if the guess finds no stream of a robot.
pub(crate) fn read_foreign<R: Read>(
    open: &Open<'_, R>,
    path: &Path,
    map: Option<&TopicMap>,
) -> Result<Spooled> {
    let topics = survey(open, path)?;
    let mut warnings = Vec::new();
    let guessed;
    let map = match map {
        Some(map) => map,
        None => {
            guessed = guess(&topics);
            let text = guessed.to_text();
            warnings.push(format!("{}: guessed topics:\n{text}", path.display()));
            &guessed
        }
    };
    let disk = Disk::default();
    let mut streams = open_streams(&disk, path, map, &topics)?;
    let start_ns = start_time_ns(map, &topics, &streams);
    let mut left_out: BTreeMap<String, u64> = BTreeMap::new();
    let loss = scan(open, path, &mut |item| {
        let Item::Message {
            channel,
            log_time_ns,
            data,
            ..
        } = item
        else {
            return Ok(());
        };
        let mut visited: Option<VisitResult> = None;
        for (_, stream) in streams.iter_mut().filter(|(t, _)| *t == channel.topic) {
            let log_ns = i64::try_from(log_time_ns).unwrap_or(i64::MAX);
            let t_s = |stamp_ns| s_from_ns(time_ns(map, stamp_ns, log_ns).saturating_sub(start_ns));
            let pushed = stream.push_message(&channel.schema, data, t_s);
            visited = Some(visited.unwrap_or(Ok(())).and(pushed));
        }
        visited.unwrap_or_else(|| {
            *left_out.entry(channel.topic.clone()).or_default() += 1;
            Ok(())
        })
    })?;
    if loss.any() {
        warnings.push(format!("{}: {loss}", path.display()));
    }
    let name = path.file_stem().map(|stem| stem.to_string_lossy());
    let description = Recording {
        name: name.unwrap_or_default().into_owned(),
        origin: format!("ROS 2 bag, times from {} s", s_from_ns(start_ns)),
        ..Recording::default()
    };
    let mut recording = SpooledRecording::new(description, disk);
    for (_, stream) in streams {
        stream.finish(&mut recording, &mut warnings);
    }
    recording.disk.check()?;
    Ok(Spooled {
        recording,
        warnings,
        loss: Some(loss),
        left_out,
    })
}

/// Time of a message (ns): its stamp, or its log time if it has no stamp or the map asks for it.
fn time_ns(map: &TopicMap, stamp_ns: Option<i64>, log_ns: i64) -> i64 {
    match stamp_ns {
        Some(stamp_ns) if stamp_ns != 0 && !map.log_times => stamp_ns,
        _ => log_ns,
    }
}

/// An empty stream for each entry of the map, with its topic.
fn open_streams(
    disk: &Disk,
    path: &Path,
    map: &TopicMap,
    topics: &[Topic],
) -> std::result::Result<Vec<(String, StreamBuilder)>, InputError> {
    let mut streams = Vec::new();
    for source in &map.sources {
        let topic = topics
            .iter()
            .find(|topic| topic.channel.topic == source.topic);
        let Some(topic) = topic else {
            let names: Vec<&str> = topics
                .iter()
                .map(|topic| topic.channel.topic.as_str())
                .collect();
            let problem = format!("has no topic {}", source.topic);
            let remedy = format!("name one of: {}", names.join(", "));
            return Err(InputError::file(path, problem, remedy));
        };
        let Some(columns) = source.columns(&topic.channel.schema) else {
            let (name, schema) = (source.kind.name(), &topic.channel.schema);
            let problem = format!(
                "{} is a {schema}, which cannot provide {name}",
                source.topic
            );
            return Err(InputError::file(path, problem, "map another topic"));
        };
        let columns: Vec<String> = columns.iter().map(|&name| name.to_owned()).collect();
        let stream = StreamBuilder::new(disk, &source.robot, source.kind, &columns, &[]);
        let mut stream = stream.map_err(|e| InputError::file(path, e, "map another topic"))?;
        stream.selector = source.selector.clone();
        streams.push((source.topic.clone(), stream));
    }
    if streams.is_empty() {
        let problem = "no topic looks like a stream of a robot";
        let remedy = "give a topic map with --topics; README.md shows one";
        return Err(InputError::file(path, problem, remedy));
    }
    Ok(streams)
}

/// The earliest first time of the mapped topics (ns).
fn start_time_ns(map: &TopicMap, topics: &[Topic], streams: &[(String, StreamBuilder)]) -> i64 {
    let mapped = topics
        .iter()
        .filter(|topic| streams.iter().any(|(name, _)| *name == topic.channel.topic));
    let times = mapped.map(|topic| time_ns(map, topic.first_stamp_ns, topic.first_log_ns));
    times.min().unwrap_or_default()
}
