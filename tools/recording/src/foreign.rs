//! ROS 2 bags (MCAP) of other robots: by a map of topics, or by a guess that is said aloud.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use crate::bag::reader::{ChannelInfo, Item, Visited, read_bag};
use crate::build::StreamBuilder;
use crate::csv_in::Import;
use crate::error::{Result, Unusable};
use crate::open::BUFFER;
use crate::recording::Recording;
use crate::ros2::cdr::decode;
use crate::ros2::messages::JointState;
use crate::sample::{Pick, Sample};
use crate::table::StreamKind;
use crate::time::s_from_ns;
use crate::topic_map::{Quantity, Source, TopicMap};

/// What a first look at the bag tells about a topic.
struct Topic {
    info: Arc<ChannelInfo>,
    messages: u64,
    first_log_ns: i64,
    first_stamp_ns: Option<i64>,
    joints: Option<Joints>,
}

/// The first joint state of a topic.
struct Joints {
    names: Vec<String>,
    has_angles: bool,
    has_speeds: bool,
    has_torques: bool,
}

/// Reads a bag of another robot. Without a map the topics are guessed, and the guess is among the
/// warnings as a map that can be saved and mended.
///
/// # Errors
/// When it is no MCAP file, or nothing in it is a stream of a robot.
pub(crate) fn read_foreign(path: &Path, map: Option<&TopicMap>) -> Result<Import> {
    let topics = survey(path)?;
    let mut warnings = Vec::new();
    let guessed;
    let map = match map {
        Some(map) => map,
        None => {
            guessed = guess(&topics);
            let text = guessed.to_text();
            warnings.push(format!("{}: topics guessed as\n{text}", path.display()));
            &guessed
        }
    };
    let mut streams = open_streams(path, map, &topics)?;
    let start_ns = start(map, &topics, &streams);
    let mut left_out: BTreeMap<String, u64> = BTreeMap::new();
    let loss = scan(path, &mut |item| {
        let Item::Message {
            channel,
            log_time_ns,
            data,
            ..
        } = item
        else {
            return Ok(());
        };
        let mut visited: Option<Visited> = None;
        for (topic, stream) in streams.iter_mut().filter(|(t, _)| *t == channel.topic) {
            debug_assert_eq!(*topic, channel.topic);
            let log_ns = i64::try_from(log_time_ns).unwrap_or(i64::MAX);
            let t_s = |stamp_ns| s_from_ns(time(map, stamp_ns, log_ns).saturating_sub(start_ns));
            let one = stream.push_message(&channel.schema, data, t_s);
            visited = Some(visited.unwrap_or(Ok(())).and(one));
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
    let mut recording = Recording {
        name: name.unwrap_or_default().into_owned(),
        origin: format!("ROS 2 bag, times from {} s", s_from_ns(start_ns)),
        ..Recording::default()
    };
    for (_, stream) in streams {
        stream.finish(&mut recording, &mut warnings);
    }
    Ok(Import {
        recording,
        warnings,
        loss: Some(loss),
        left_out,
    })
}

fn scan(
    path: &Path,
    visit: &mut dyn FnMut(Item<'_>) -> Visited,
) -> std::result::Result<crate::Loss, Unusable> {
    let file = File::open(path).map_err(|e| Unusable::unreadable(path, &e))?;
    let size = file
        .metadata()
        .map_err(|e| Unusable::unreadable(path, &e))?;
    read_bag(
        BufReader::with_capacity(BUFFER, file),
        size.len(),
        path,
        visit,
    )
}

/// The time of a message (ns): its stamp, unless it has none or the map wants the time of logging.
fn time(map: &TopicMap, stamp_ns: Option<i64>, log_ns: i64) -> i64 {
    match stamp_ns {
        Some(stamp_ns) if stamp_ns != 0 && !map.log_times => stamp_ns,
        _ => log_ns,
    }
}

/// Looks at the first message of every topic.
fn survey(path: &Path) -> std::result::Result<Vec<Topic>, Unusable> {
    let mut topics: Vec<Topic> = Vec::new();
    let mut places: BTreeMap<u16, usize> = BTreeMap::new();
    scan(path, &mut |item| {
        let Item::Message {
            id,
            channel,
            log_time_ns,
            data,
        } = item
        else {
            return Ok(());
        };
        let place = *places.entry(id).or_insert_with(|| {
            topics.push(first_look(channel, log_time_ns, data));
            topics.len() - 1
        });
        if let Some(topic) = topics.get_mut(place) {
            topic.messages += 1;
        }
        Ok(())
    })?;
    topics.sort_by(|a, b| a.info.topic.cmp(&b.info.topic));
    Ok(topics)
}

fn first_look(channel: &Arc<ChannelInfo>, log_time_ns: u64, data: &[u8]) -> Topic {
    let joints = (channel.schema == "sensor_msgs/msg/JointState")
        .then(|| decode::<JointState<String, Vec<String>, Vec<f64>>>(data).ok())
        .flatten()
        .map(|state| Joints {
            has_angles: !state.position.is_empty(),
            has_speeds: !state.velocity.is_empty(),
            has_torques: !state.effort.is_empty(),
            names: state.name,
        });
    let pick = match &joints {
        Some(joints) => wheel_joints(&joints.names).unwrap_or_default(),
        None => Pick::default(),
    };
    let sample = Sample::decode(&channel.schema, &pick, data);
    Topic {
        info: Arc::clone(channel),
        messages: 0,
        first_log_ns: i64::try_from(log_time_ns).unwrap_or(i64::MAX),
        first_stamp_ns: sample.ok().and_then(|sample| sample.t_ns),
        joints,
    }
}

/// The names of the right and left wheel among the joints; of several pairs the first.
fn wheel_joints(names: &[String]) -> Option<Pick> {
    let side = |side: &str| {
        let of_side = |name: &&String| name.to_lowercase().contains(side);
        let is_wheel = |name: &&String| name.to_lowercase().contains("wheel");
        let wheel = names.iter().filter(of_side).find(is_wheel);
        wheel.or_else(|| names.iter().find(of_side)).cloned()
    };
    Some(Pick {
        joints: [side("right")?, side("left")?],
        frame: None,
    })
}

/// What each topic most likely is. Of several that could be the same stream, the one with most
/// messages.
fn guess(topics: &[Topic]) -> TopicMap {
    let mut candidates: Vec<(u64, Source)> = Vec::new();
    for topic in topics.iter().filter(|topic| topic.info.encoding == "cdr") {
        if let Some(source) = guess_one(topic) {
            let same = |(_, other): &&mut (u64, Source)| {
                (&other.robot, other.kind) == (&source.robot, source.kind)
            };
            match candidates.iter_mut().find(same) {
                Some(other) if other.0 < topic.messages => *other = (topic.messages, source),
                Some(_) => {}
                None => candidates.push((topic.messages, source)),
            }
        }
    }
    candidates.sort_by(|(_, a), (_, b)| (&a.robot, a.kind).cmp(&(&b.robot, b.kind)));
    TopicMap {
        log_times: false,
        sources: candidates.into_iter().map(|(_, source)| source).collect(),
    }
}

fn guess_one(topic: &Topic) -> Option<Source> {
    let name = topic.info.topic.to_lowercase();
    let any = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let is_command = any(&["cmd", "command", "target", "desired", "setpoint"]);
    let is_truth = any(&[
        "truth",
        "mocap",
        "vicon",
        "optitrack",
        "gt",
        "pose",
        "camera",
    ]);
    let (kind, pick, quantity) = match (topic.info.schema.rsplit('/').next()?, &topic.joints) {
        ("Twist" | "TwistStamped", _) if is_command => (StreamKind::Command, Pick::default(), None),
        ("TwistStamped", _) => (StreamKind::Odometry, Pick::default(), None),
        ("Odometry", _) if is_truth => (StreamKind::Pose, Pick::default(), None),
        ("Odometry", _) => (StreamKind::Odometry, Pick::default(), None),
        ("PoseStamped" | "PoseWithCovarianceStamped", _) => {
            (StreamKind::Pose, Pick::default(), None)
        }
        ("Imu", _) => (StreamKind::Imu, Pick::default(), None),
        ("EncoderTicks", _) => (StreamKind::Wheels, Pick::default(), None),
        ("JointState", Some(joints)) => {
            let pick = wheel_joints(&joints.names)?;
            let (kind, quantity) = match is_command {
                true if joints.has_torques => (StreamKind::Command, Quantity::Torque),
                true if joints.has_speeds => (StreamKind::Command, Quantity::Speed),
                false if joints.has_angles => (StreamKind::Wheels, Quantity::Angle),
                false if joints.has_speeds => (StreamKind::Wheels, Quantity::Speed),
                _ => return None,
            };
            (kind, pick, Some(quantity))
        }
        _ => return None,
    };
    Some(Source {
        robot: robot_of(&topic.info.topic),
        kind,
        topic: topic.info.topic.clone(),
        pick,
        quantity,
    })
}

/// A topic's robot: its first part where it has several, such as `r1` of `/r1/odom`. Parts that
/// name a sensor and not a robot do not count.
fn robot_of(topic: &str) -> String {
    const SENSORS: [&str; 12] = [
        "imu",
        "odom",
        "odometry",
        "camera",
        "vicon",
        "mocap",
        "optitrack",
        "cmd_vel",
        "sensors",
        "joint_states",
        "diff_drive_controller",
        "platform",
    ];
    let mut parts = topic.split('/').filter(|part| !part.is_empty());
    match (parts.next(), parts.next()) {
        (Some(robot), Some(_))
            if !SENSORS.contains(&robot) && crate::recording::is_robot_name(robot) =>
        {
            robot.to_owned()
        }
        _ => "robot".to_owned(),
    }
}

/// An empty stream for each source of the map, with its topic.
fn open_streams(
    path: &Path,
    map: &TopicMap,
    topics: &[Topic],
) -> std::result::Result<Vec<(String, StreamBuilder)>, Unusable> {
    let mut streams = Vec::new();
    for source in &map.sources {
        let known = topics.iter().find(|topic| topic.info.topic == source.topic);
        let Some(topic) = known else {
            let names: Vec<&str> = topics
                .iter()
                .map(|topic| topic.info.topic.as_str())
                .collect();
            let problem = format!("has no topic {}", source.topic);
            let remedy = format!("name one of: {}", names.join(", "));
            return Err(Unusable::new(path, problem, remedy));
        };
        let Some(columns) = source.columns(&topic.info.schema) else {
            let (name, schema) = (source.kind.name(), &topic.info.schema);
            let problem = format!("{} is a {schema}, which gives no {name}", source.topic);
            return Err(Unusable::new(path, problem, "map another topic"));
        };
        let columns: Vec<String> = columns.iter().map(|&name| name.to_owned()).collect();
        let stream = StreamBuilder::new(&source.robot, source.kind, &columns, &[]);
        let mut stream = stream.map_err(|e| Unusable::new(path, e, "map another topic"))?;
        stream.pick = source.pick.clone();
        streams.push((source.topic.clone(), stream));
    }
    if streams.is_empty() {
        let problem = "no topic of it could be guessed to be a robot's stream";
        let remedy = "give a map with --topics; README.md shows one";
        return Err(Unusable::new(path, problem, remedy));
    }
    Ok(streams)
}

/// The earliest first time of the mapped topics (ns).
fn start(map: &TopicMap, topics: &[Topic], streams: &[(String, StreamBuilder)]) -> i64 {
    let mapped = topics
        .iter()
        .filter(|topic| streams.iter().any(|(name, _)| *name == topic.info.topic));
    let times = mapped.map(|topic| time(map, topic.first_stamp_ns, topic.first_log_ns));
    times.min().unwrap_or_default()
}
