//! Reader of bags of other robots.

use std::path::Path;

use slipstream_bag::ros::time::s_from_ns;
use slipstream_bag::{Bag, Result};
use slipstream_bus::InputError;

use super::clock::Clock;
use super::description::{InBag, WheelNames, descriptions};
use super::guess::guess;
use super::idle::idle_twists;
use super::neighbours::MOST_GAP_S;
use super::opening::open_streams;
use super::problems::{no_stream, problem};
use super::reading::{Reading, Way, read_streams};
use super::survey::{Topic, survey};
use super::topic_map::TopicMap;
use crate::decode::StreamBuilder;
use crate::import::Spooled;
use crate::recording::{PosePoint, ReadFrom, Recording, Robot};
use crate::rows::{Disk, SpooledRecording};

/// Reads a bag of another robot, and the descriptions of robots in it. Without a map, one is guessed from the topics
/// and from the wheels that descriptions name. Times count from the first message of the mapped topics.
///
/// # Errors
/// If it is not a bag, if a topic of the map does not exist or cannot provide its stream, if a stream of the map
/// would be empty, or if the guess finds no stream of a robot.
pub(crate) fn read_foreign(
    bag: &dyn Bag,
    path: &Path,
    map: Option<&TopicMap>,
    wheels: &WheelNames<'_>,
) -> Result<(Spooled, Vec<InBag>)> {
    let mapped = map.map_or_else(Vec::new, TopicMap::topics);
    let (topics, loss) = survey(bag, &mapped)?;
    let described = descriptions(&topics);
    let mut guesses = Vec::new();
    let mut warnings = Vec::new();
    let guessed;
    let chosen = match map {
        Some(map) => map,
        None => {
            let guess = guess(&topics, &wheels.all(&described));
            let text = guess.map.to_text();
            guesses.push(format!("{}: guessed topics:\n{text}", path.display()));
            guesses.extend(guess.notes);
            warnings.extend(guess.left_out);
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
        way,
    } in streams
    {
        let note = finish(way, &mut stream);
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
        guesses,
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
    Ok(descriptions(&survey(bag, &[])?.0))
}

/// Puts what was collected into a stream. Returns what a person should know about it.
fn finish(way: Way, stream: &mut StreamBuilder) -> Option<String> {
    match way {
        Way::Messages | Way::Fields(_) => None,
        Way::Composed(composed) => Some(composed.finish(stream)),
        Way::Apart(apart) => {
            let left_out = apart.finish(stream);
            (left_out > 0).then(|| {
                let (robot, kind) = (&stream.robot, stream.kind.name());
                format!(
                    "{robot}/{kind}: left out where the other wheel has no values for more than {MOST_GAP_S} s: {left_out} values"
                )
            })
        }
    }
}

/// The clock of the mapped topics.
pub(super) fn clock(
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
pub(super) fn description(path: &Path, map: &TopicMap, clock: Clock) -> Recording {
    let name = path.file_stem().map(|stem| stem.to_string_lossy());
    let mut recording = Recording {
        name: name.unwrap_or_default().into_owned(),
        origin: format!("ROS bag, times from {} s", s_from_ns(clock.start_ns)),
        read_from: ReadFrom::Bag,
        ..Recording::default()
    };
    for source in &map.sources {
        if recording.robot(&source.robot).is_none() {
            let entry = map.robots.iter().find(|own| own.name == source.robot);
            let point = match entry.is_some_and(|own| own.is_pose_of_mass) {
                true => PosePoint::CentreOfMass,
                false => PosePoint::Axle,
            };
            recording.robots.push(Robot {
                pose_point: Some(point),
                encoder_counts_per_rev: entry.and_then(|own| own.encoder_counts_per_rev),
                ..Robot::named(&source.robot)
            });
        }
    }
    recording
}
