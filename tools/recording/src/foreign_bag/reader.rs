//! Reader of bags of other robots.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use slipstream_bus::InputError;

use super::clock::Clock;
use super::guess::{Guess, guess};
use super::survey::{Topic, survey};
use super::topic_map::{Source, TopicMap};
use crate::bag::{Bag, Item, Loss, VisitResult};
use crate::decode::StreamBuilder;
use crate::error::Result;
use crate::import::Spooled;
use crate::recording::{PosePoint, Recording, Robot};
use crate::ros::time::s_from_ns;
use crate::rows::{Disk, SpooledRecording};

/// Reads a bag of another robot. Without a map, one is guessed and given in the warnings. Times count from the first
/// message of the mapped topics.
///
/// # Errors
/// If it is not a bag, if a topic of the map does not exist or cannot provide its stream, if a stream of the map
/// would be empty, or if the guess finds no stream of a robot.
pub(crate) fn read_foreign(bag: &dyn Bag, path: &Path, map: Option<&TopicMap>) -> Result<Spooled> {
    let (topics, loss) = survey(bag)?;
    let mut warnings = Vec::new();
    let guessed;
    let chosen = match map {
        Some(map) => map,
        None => {
            let guess = guess(&topics);
            let text = guess.map.to_text();
            warnings.push(format!("{}: guessed topics:\n{text}", path.display()));
            warnings.extend(guess.notes);
            guessed = guess.map;
            &guessed
        }
    };
    if chosen.sources.is_empty() {
        return Err(no_stream(path, &topics, &loss).into());
    }
    let disk = Disk::default();
    let mut streams = open_streams(&disk, path, chosen, &topics)?;
    let clock = clock(chosen, &topics, &mut warnings);
    let mut left_out: BTreeMap<String, u64> = BTreeMap::new();
    let loss = bag.scan(&mut |item| {
        let Item::Message {
            channel,
            log_time_ns,
            data,
            ..
        } = item
        else {
            return Ok(());
        };
        let log_ns = i64::try_from(log_time_ns).unwrap_or(i64::MAX);
        let mut visited: Option<VisitResult> = None;
        for (source, stream) in &mut streams {
            if source.topic == channel.topic {
                let t_s = |stamp_ns| s_from_ns(clock.time_ns(stamp_ns, log_ns));
                let pushed = stream.push_message(channel, data, t_s);
                visited = Some(visited.unwrap_or(Ok(())).and(pushed));
            }
        }
        visited.unwrap_or_else(|| {
            match left_out.get_mut(&channel.topic) {
                Some(count) => *count += 1,
                None => drop(left_out.insert(channel.topic.clone(), 1)),
            }
            Ok(())
        })
    })?;
    if loss.any() {
        warnings.push(format!("{}: {loss}", path.display()));
    }
    let mut recording = SpooledRecording::new(description(path, chosen, clock), disk);
    for (source, stream) in streams {
        match problem(&source, &stream, &topics) {
            None => stream.finish(&mut recording, &mut warnings),
            Some((problem, remedy)) if map.is_some() => {
                return Err(InputError::file(path, problem, remedy).into());
            }
            Some((problem, _)) => warnings.push(format!("{problem}; left out")),
        }
    }
    recording.disk.check()?;
    Ok(Spooled {
        recording,
        warnings,
        loss: Some(loss),
        left_out,
    })
}

/// The guess of a map as text, with comments on the topics that it leaves out.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(crate) fn draft_topics(bag: &dyn Bag) -> Result<String> {
    let (topics, _) = survey(bag)?;
    let Guess { map, notes } = guess(&topics);
    let mut text = String::from(
        "# Which topic is which stream of which robot, as guessed. Correct it, then give it with --topics.\n",
    );
    for note in notes {
        let _ = writeln!(text, "# {note}");
    }
    text.push_str(&map.to_text());
    let mut others = String::new();
    for topic in &topics {
        let (name, schema) = (&topic.channel.topic, &topic.channel.schema);
        if map.sources.iter().all(|source| source.topic != *name) {
            let _ = write!(others, "# {name}: {} messages, {schema}", topic.messages);
            let joints: Vec<&str> = topic.joints.keys().map(String::as_str).collect();
            if !joints.is_empty() {
                let _ = write!(others, ", joints {}", joints.join(", "));
            }
            let frames = topic.frames.keys();
            let frames = frames.map(|[parent, child]| format!("{parent} to {child}"));
            let frames: Vec<String> = frames.collect();
            if !frames.is_empty() {
                let _ = write!(others, ", transforms {}", frames.join(", "));
            }
            others.push('\n');
        }
    }
    if !others.is_empty() {
        text.push_str("# Topics that are left out:\n");
        text.push_str(&others);
    }
    Ok(text)
}

/// The clock of the mapped topics.
fn clock(map: &TopicMap, topics: &[Topic], warnings: &mut Vec<String>) -> Clock {
    let is_mapped = |topic: &&Topic| {
        let mut sources = map.sources.iter();
        sources.any(|source| source.topic == topic.channel.topic)
    };
    let mapped = || topics.iter().filter(is_mapped);
    for topic in mapped().filter(|topic| topic.times.zero > 0 && !map.log_times) {
        let (name, zero, all) = (&topic.channel.topic, topic.times.zero, topic.messages);
        warnings.push(format!(
            "{name}: {zero} of {all} stamps are 0; times of reception stand for them"
        ));
    }
    Clock::of(mapped().map(|topic| &topic.times), map.log_times, warnings)
}

/// The description of the recording, with its robots.
fn description(path: &Path, map: &TopicMap, clock: Clock) -> Recording {
    let name = path.file_stem().map(|stem| stem.to_string_lossy());
    let mut recording = Recording {
        name: name.unwrap_or_default().into_owned(),
        origin: format!("ROS bag, times from {} s", s_from_ns(clock.start_ns)),
        ..Recording::default()
    };
    for source in &map.sources {
        if recording.robot(&source.robot).is_none() {
            let is_of_mass = map.with_pose_of_mass.contains(&source.robot);
            let point = if is_of_mass {
                PosePoint::CentreOfMass
            } else {
                PosePoint::Axle
            };
            recording.robots.push(Robot {
                pose_point: Some(point),
                ..Robot::named(&source.robot)
            });
        }
    }
    recording
}

/// An empty stream for each entry of the map.
fn open_streams(
    disk: &Disk,
    path: &Path,
    map: &TopicMap,
    topics: &[Topic],
) -> std::result::Result<Vec<(Source, StreamBuilder)>, InputError> {
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
        streams.push((source.clone(), stream));
    }
    Ok(streams)
}

/// Why the guess finds nothing.
fn no_stream(path: &Path, topics: &[Topic], loss: &Loss) -> InputError {
    if topics.is_empty() {
        let problem = match loss.any() {
            true => format!("has no messages that can be read: {loss}"),
            false => "has no messages".to_owned(),
        };
        return InputError::file(path, problem, "give a bag with messages");
    }
    let names = topics.iter().take(20).map(|topic| {
        let (name, schema) = (&topic.channel.topic, &topic.channel.schema);
        format!("{name} ({schema}, {})", topic.channel.encoding)
    });
    let names: Vec<String> = names.collect();
    let problem = format!(
        "no topic looks like a stream of a robot: {}",
        names.join(", ")
    );
    let remedy = "say which topic is which stream in a map for --topics; `slipstream check BAG --write-topics \
                  FILE.toml` writes one to be completed";
    InputError::file(path, problem, remedy)
}

/// What is wrong with a stream that was read, and the remedy.
fn problem(source: &Source, stream: &StreamBuilder, topics: &[Topic]) -> Option<(String, String)> {
    let topic = topics
        .iter()
        .find(|topic| topic.channel.topic == source.topic)?;
    let (name, kind) = (&source.topic, source.kind.name());
    let missing = missing_joints(source, topic);
    if !missing.is_empty() {
        let known: Vec<&str> = topic.joints.keys().map(String::as_str).collect();
        let problem = format!("{name} has no joint {}", missing.join(", "));
        return Some((problem, format!("name one of: {}", known.join(", "))));
    }
    if stream.is_empty() && !topic.frames.is_empty() {
        let frames = topic
            .frames
            .keys()
            .map(|[parent, child]| format!("{parent} to {child}"));
        let frames: Vec<String> = frames.collect();
        let problem = format!("{name} has no such transform for {kind}");
        return Some((
            problem,
            format!("name the parent and frame of one of: {}", frames.join(", ")),
        ));
    }
    let empty = stream.empty_columns();
    if empty.is_empty() {
        return None;
    }
    let problem = format!("{name} gives no value for {} of {kind}", empty.join(", "));
    let remedy = "map another topic or quantity, or leave the stream out";
    Some((problem, remedy.to_owned()))
}

/// The joints of a map that the topic does not have.
fn missing_joints(source: &Source, topic: &Topic) -> Vec<String> {
    if topic.type_name() != "JointState" {
        return Vec::new();
    }
    let joints = source.selector.joints.iter().flatten();
    let missing = joints.filter(|joint| !topic.joints.contains_key(*joint));
    missing.cloned().collect()
}
