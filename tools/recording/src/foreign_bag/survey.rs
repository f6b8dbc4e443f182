//! A first look at the topics of a bag.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::bag::{self, ChannelInfo, Item, Loss, Visited, read_bag};
use crate::decode::{Pick, Sample};
use crate::error::Unusable;
use crate::ros2::cdr::decode;
use crate::ros2::messages::JointState;

/// What a first look at the bag tells about a topic.
pub(super) struct Topic {
    pub(super) info: Arc<ChannelInfo>,
    pub(super) messages: u64,
    pub(super) first_log_ns: i64,
    pub(super) first_stamp_ns: Option<i64>,
    pub(super) joints: Option<Joints>,
}

/// The first joint state of a topic.
pub(super) struct Joints {
    pub(super) names: Vec<String>,
    pub(super) has_angles: bool,
    pub(super) has_speeds: bool,
    pub(super) has_torques: bool,
}

/// Reads a whole bag.
pub(super) fn scan(
    path: &Path,
    visit: &mut dyn FnMut(Item<'_>) -> Visited,
) -> Result<Loss, Unusable> {
    let (source, size) = bag::open(path)?;
    read_bag(source, size, path, visit)
}

/// Looks at the first message of every topic.
pub(super) fn survey(path: &Path) -> Result<Vec<Topic>, Unusable> {
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
pub(super) fn wheel_joints(names: &[String]) -> Option<Pick> {
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
