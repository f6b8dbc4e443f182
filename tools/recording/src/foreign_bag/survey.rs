//! Survey of a bag: its topics, with the number of messages and the first message of each.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use slipstream_bus::InputError;

use crate::bag::{ChannelInfo, Item, Loss, VisitResult, read_bag};
use crate::decode::{MessageSelector, Sample};
use crate::ros2::MessageType;
use crate::ros2::cdr::decode;
use crate::ros2::messages::JointState;

/// A topic of the bag.
pub(super) struct Topic {
    pub(super) channel: Arc<ChannelInfo>,
    /// Number of messages.
    pub(super) messages: u64,
    /// Log time of the first message (ns).
    pub(super) first_log_ns: i64,
    /// Stamp of the first message (ns), if it has one.
    pub(super) first_stamp_ns: Option<i64>,
    /// The first message, if it is a joint state.
    pub(super) joints: Option<Joints>,
}

/// What a joint state contains.
pub(super) struct Joints {
    pub(super) names: Vec<String>,
    pub(super) has_angles: bool,
    pub(super) has_speeds: bool,
    pub(super) has_torques: bool,
}

/// Opens the bag from its beginning: its reader and its size (bytes). A bag is read twice.
pub(crate) type Open<'a, R> = dyn Fn() -> Result<(R, u64), InputError> + 'a;

/// Reads a whole bag and calls `visit` with each item.
///
/// # Errors
/// If it is not an MCAP file or cannot be read.
pub(super) fn scan<R: Read>(
    open: &Open<'_, R>,
    path: &Path,
    visit: &mut dyn FnMut(Item<'_>) -> VisitResult,
) -> Result<Loss, InputError> {
    let (source, size) = open()?;
    read_bag(source, size, path, visit)
}

/// The topics of a bag, sorted by name.
///
/// # Errors
/// As [`scan`].
pub(super) fn survey<R: Read>(open: &Open<'_, R>, path: &Path) -> Result<Vec<Topic>, InputError> {
    let mut topics: Vec<Topic> = Vec::new();
    let mut index_of_channel: BTreeMap<u16, usize> = BTreeMap::new();
    scan(open, path, &mut |item| {
        let Item::Message {
            id,
            channel,
            log_time_ns,
            data,
        } = item
        else {
            return Ok(());
        };
        let index = *index_of_channel.entry(id).or_insert_with(|| {
            topics.push(inspect(channel, log_time_ns, data));
            topics.len() - 1
        });
        if let Some(topic) = topics.get_mut(index) {
            topic.messages += 1;
        }
        Ok(())
    })?;
    topics.sort_by(|a, b| a.channel.topic.cmp(&b.channel.topic));
    Ok(topics)
}

/// A topic as its first message shows it.
fn inspect(channel: &Arc<ChannelInfo>, log_time_ns: u64, data: &[u8]) -> Topic {
    let joints = (channel.schema == MessageType::JointState.name())
        .then(|| decode::<JointState<String, Vec<String>, Vec<f64>>>(data).ok())
        .flatten()
        .map(|state| Joints {
            has_angles: !state.position.is_empty(),
            has_speeds: !state.velocity.is_empty(),
            has_torques: !state.effort.is_empty(),
            names: state.name,
        });
    let selector = match &joints {
        Some(joints) => wheel_joints(&joints.names).unwrap_or_default(),
        None => MessageSelector::default(),
    };
    let sample = Sample::decode(&channel.schema, &selector, data);
    Topic {
        channel: Arc::clone(channel),
        messages: 0,
        first_log_ns: i64::try_from(log_time_ns).unwrap_or(i64::MAX),
        first_stamp_ns: sample.ok().and_then(|sample| sample.t_ns),
        joints,
    }
}

/// Selects the joints of the right and the left wheel by their names, the first pair of several.
pub(super) fn wheel_joints(names: &[String]) -> Option<MessageSelector> {
    let joint = |side: &str| {
        let is_side = |name: &&String| name.to_lowercase().contains(side);
        let is_wheel = |name: &&String| name.to_lowercase().contains("wheel");
        let wheel = names.iter().filter(is_side).find(is_wheel);
        wheel.or_else(|| names.iter().find(is_side)).cloned()
    };
    Some(MessageSelector {
        joints: [joint("right")?, joint("left")?],
        frame: None,
    })
}
