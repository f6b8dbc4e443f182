//! Reader of bags of other robots.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use slipstream_bus::InputError;

use super::chain::Chain;
use super::clock::Clock;
use super::composed::Composed;
use super::description::{InBag, WheelJoints, WheelsOf, descriptions};
use super::guess::{Guess, guess};
use super::reading::{Reading, read_streams};
use super::survey::{Topic, survey};
use super::topic_map::{Source, TopicMap};
use crate::bag::{Bag, Loss};
use crate::decode::{PoseSpeeds, StreamBuilder};
use crate::error::Result;
use crate::import::Spooled;
use crate::recording::{PosePoint, Recording, Robot};
use crate::ros::time::s_from_ns;
use crate::rows::{Disk, SpooledRecording};
use crate::table::StreamKind;

/// Reads a bag of another robot, and the descriptions of robots in it. Without a map, one is guessed and given in the
/// warnings; `wheels_of` tells it the wheels of a description. Times count from the first message of the mapped topics.
///
/// # Errors
/// If it is not a bag, if a topic of the map does not exist or cannot provide its stream, if a stream of the map
/// would be empty, or if the guess finds no stream of a robot.
pub(crate) fn read_foreign(
    bag: &dyn Bag,
    path: &Path,
    map: Option<&TopicMap>,
    wheels_of: &WheelsOf<'_>,
) -> Result<(Spooled, Vec<InBag>)> {
    let (topics, loss) = survey(bag)?;
    let described = descriptions(&topics);
    let mut warnings = Vec::new();
    let guessed;
    let chosen = match map {
        Some(map) => map,
        None => {
            let guess = guess(&topics, &wheels_in(&described, wheels_of));
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
    warnings.extend(idle_twists(&mut streams, &topics));
    let clock = clock(chosen, &streams, &topics, &mut warnings);
    let (loss, mut left_out) = read_streams(bag, &mut streams, clock)?;
    for own in &described {
        left_out.remove(&own.topic);
    }
    if loss.any() {
        warnings.push(format!("{}: {loss}", path.display()));
    }
    let mut recording = SpooledRecording::new(description(path, chosen, clock), disk);
    for Reading {
        source,
        mut stream,
        composed,
    } in streams
    {
        let note = composed.map(|composed| composed.finish(&mut stream));
        match problem(&source, &stream, &topics) {
            None => {
                warnings.extend(note);
                stream.finish(&mut recording, &mut warnings);
            }
            Some((problem, remedy)) if map.is_some() => {
                return Err(InputError::file(path, problem, remedy).into());
            }
            Some((problem, _)) => warnings.push(format!("{problem}; left out")),
        }
    }
    recording.disk.check()?;
    let spooled = Spooled {
        recording,
        guesses: Vec::new(),
        warnings,
        on_model: Vec::new(),
        loss: Some(loss),
        left_out,
    };
    Ok((spooled, described))
}

/// The descriptions of robots in a bag.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(crate) fn descriptions_in(bag: &dyn Bag) -> Result<Vec<InBag>> {
    Ok(descriptions(&survey(bag)?.0))
}

/// The wheels that descriptions name.
fn wheels_in(described: &[InBag], wheels_of: &WheelsOf<'_>) -> Vec<WheelJoints> {
    described.iter().filter_map(wheels_of).collect()
}

/// The guess of a map as text, with comments on the topics that it leaves out.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(crate) fn draft_topics(bag: &dyn Bag, wheels_of: &WheelsOf<'_>) -> Result<String> {
    let (topics, _) = survey(bag)?;
    let wheels = wheels_in(&descriptions(&topics), wheels_of);
    let Guess { map, notes } = guess(&topics, &wheels);
    let mut text = String::from(
        "# Which topic is which stream of which robot, as guessed. Correct it, then give it with --topics.\n",
    );
    for note in notes {
        let _ = writeln!(text, "# {note}");
    }
    for source in &map.sources {
        let mut same = topics.iter();
        let topic = same.find(|topic| topic.channel.topic == source.topic);
        if let Some(chain) = topic.and_then(|topic| chain(source, topic, &topics)) {
            let (kind, name) = (source.kind.name(), chain.name());
            let _ = writeln!(text, "# {}/{kind}: composed of {name}", source.robot);
        }
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
fn clock(
    map: &TopicMap,
    streams: &[Reading],
    topics: &[Topic],
    warnings: &mut Vec<String>,
) -> Clock {
    let is_mapped = |topic: &&Topic| {
        let name = &topic.channel.topic;
        streams
            .iter()
            .any(|reading| reading.topics().contains(name))
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
) -> std::result::Result<Vec<Reading>, InputError> {
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
        let chain = chain(source, topic, topics);
        streams.push(Reading {
            source: source.clone(),
            stream,
            composed: chain.map(|chain| Composed::new(chain, disk)),
        });
    }
    Ok(streams)
}

/// Takes the speeds of an odometry from its poses, where its driver leaves them zero. Returns a note for each.
fn idle_twists(streams: &mut [Reading], topics: &[Topic]) -> Vec<String> {
    let idle = topics.iter().filter(|topic| topic.has_idle_twist());
    let mut notes = Vec::new();
    for name in idle.map(|topic| &topic.channel.topic) {
        let is_own = |own: &Reading, kind| own.source.topic == *name && own.source.kind == kind;
        // its pose cannot be compared with itself
        let is_pose = streams.iter().any(|own| is_own(own, StreamKind::Pose));
        let odometry = streams
            .iter_mut()
            .find(|own| is_own(own, StreamKind::Odometry));
        let Some(odometry) = odometry else {
            continue;
        };
        let statement = format!("the twist of {name} is zero throughout although its pose moves");
        notes.push(if is_pose {
            format!("{statement}; let the driver fill it")
        } else {
            odometry.stream.speeds = Some(PoseSpeeds::default());
            format!("{statement}; the speeds of the odometry are those of its pose")
        });
    }
    notes
}

/// The transforms that lead to a pose, if none of the topic does alone.
fn chain(source: &Source, topic: &Topic, topics: &[Topic]) -> Option<Chain> {
    let frames = [
        source.selector.parent.clone()?,
        source.selector.frame.clone()?,
    ];
    if !topic.has_transforms() || topic.frames.contains_key(&frames) {
        return None;
    }
    let [parent, frame] = &frames;
    Chain::find(topics, &source.topic, parent, frame)
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
    if stream.is_empty() && topic.has_transforms() {
        return Some(no_transform(source, topics));
    }
    let empty = stream.empty_columns();
    if empty.is_empty() {
        return None;
    }
    let problem = format!("{name} gives no value for {} of {kind}", empty.join(", "));
    let remedy = "map another topic or quantity, or leave the stream out";
    Some((problem, remedy.to_owned()))
}

/// Why no transforms give a pose, and the remedy.
fn no_transform(source: &Source, topics: &[Topic]) -> (String, String) {
    let (name, kind) = (&source.topic, source.kind.name());
    let all = topics.iter().flat_map(|topic| topic.frames.keys());
    let all: BTreeSet<String> = all
        .map(|[parent, child]| format!("{parent} to {child}"))
        .collect();
    let all: Vec<&str> = all.iter().map(String::as_str).collect();
    let remedy = format!(
        "name a parent and a frame between which these lead: {}",
        all.join(", ")
    );
    let ends = source.selector.parent.as_ref();
    let Some((parent, frame)) = ends.zip(source.selector.frame.as_ref()) else {
        return (format!("{name} has no such transform for {kind}"), remedy);
    };
    let problem = match Chain::find(topics, name, parent, frame) {
        None => format!("{name} has no transforms that lead from {parent} to {frame} for {kind}"),
        Some(chain) if chain.moving_topics().is_empty() => {
            format!("{name}: nothing moves between {parent} and {frame}")
        }
        Some(_) => format!(
            "{name}: the transforms that lead from {parent} to {frame} have no time in common"
        ),
    };
    (problem, remedy)
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
