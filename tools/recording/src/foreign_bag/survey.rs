//! Survey of a bag: its topics, and what their messages contain.

use std::collections::BTreeMap;
use std::sync::Arc;

use slipstream_bus::InputError;

use super::clock::Times;
use super::rigid::{self, Rigid};
use crate::bag::{Bag, ChannelInfo, Item, Loss, Undecodable, VisitResult};
use crate::decode::{JointState, MessageSelector, NoSample, Sample};
use crate::ros::Encoding;
use crate::ros::messages::Header;

/// So many joints or frames of one topic are told apart. A damaged bag may claim any number of names.
const MOST_NAMES: usize = 1000;

/// Larger descriptions (bytes) are none of a robot.
const MOST_DESCRIPTION_BYTES: usize = 4 << 20;

/// A topic of the bag.
pub(super) struct Topic {
    pub(super) channel: Arc<ChannelInfo>,
    /// Number of messages.
    pub(super) messages: u64,
    /// Stamps and times of reception.
    pub(super) times: Times,
    /// The joints of joint states, by name.
    pub(super) joints: BTreeMap<String, Joint>,
    /// The transforms from a parent frame to a child frame.
    pub(super) frames: BTreeMap<[String; 2], Seen>,
    /// The last description of a robot (URDF).
    pub(super) description: Option<String>,
    /// The frame of the first message's header.
    pub(super) frame: Option<String>,
    /// What an odometry tells of its motion.
    told: Told,
}

/// What was seen of a transform.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// Number of messages.
    pub(super) count: u64,
    /// The last place that could be read.
    pub(super) place: Option<Rigid>,
    /// Whether a place differed from the one before it.
    pub(super) varies: bool,
}

/// What an odometry tells of its motion.
#[derive(Debug, Default)]
struct Told {
    /// The first pose: x (m), y (m), yaw (rad).
    first: Option<[f64; 3]>,
    /// Whether a pose was another than the first.
    moves: bool,
    /// Whether a speed was not zero.
    has_speed: bool,
}

impl Told {
    fn add(&mut self, sample: &Sample) {
        let pose = ["x_m", "y_m", "yaw_rad"].map(|name| sample.number(name));
        self.moves |= *self.first.get_or_insert(pose) != pose;
        self.has_speed |= ["v_m_s", "w_rad_s"]
            .iter()
            .any(|name| sample.number(name) != 0.0);
    }
}

/// Which lists of a joint state have values for a joint.
#[derive(Debug, Default)]
pub(super) struct Joint {
    pub(super) angle: Values,
    pub(super) speed: Values,
    pub(super) torque: Values,
}

/// The values that were seen.
#[derive(Debug, Default)]
pub(super) struct Values {
    first: Option<f64>,
    /// Whether a value differed from the first one.
    pub(super) vary: bool,
}

impl Values {
    fn add(&mut self, values: &[f64], index: usize) {
        if let Some(&value) = values.get(index).filter(|value| value.is_finite()) {
            self.vary |= *self.first.get_or_insert(value) != value;
        }
    }

    /// Whether there was any.
    pub(super) fn any(&self) -> bool {
        self.first.is_some()
    }
}

/// The topics of a bag, sorted by name, and what could not be read.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(super) fn survey(bag: &dyn Bag) -> Result<(Vec<Topic>, Loss), InputError> {
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let loss = bag.scan(&is_of_interest, &mut |item| {
        let (Item::Message { channel, .. } | Item::Unwanted { channel, .. }) = item else {
            return Ok(());
        };
        let topic = match topics.get_mut(&channel.topic) {
            Some(topic) => topic,
            None => topics
                .entry(channel.topic.clone())
                .or_insert_with(|| Topic::new(channel)),
        };
        match item {
            Item::Message {
                log_time_ns, data, ..
            } => topic.add(i64::try_from(log_time_ns).unwrap_or(i64::MAX), data),
            Item::Unwanted { messages, .. } => {
                topic.messages += messages;
                Ok(())
            }
            _ => Ok(()),
        }
    })?;
    Ok((topics.into_values().collect(), loss))
}

/// Whether messages of a topic say anything about a robot; of others, such as images, only the number counts.
fn is_of_interest(channel: &ChannelInfo) -> bool {
    Sample::can_be_of(channel) || has_description(channel)
}

/// Whether the texts of a topic describe a robot.
fn has_description(channel: &ChannelInfo) -> bool {
    channel.topic.ends_with("robot_description") && channel.schema.ends_with("/String")
}

impl Topic {
    fn new(channel: &Arc<ChannelInfo>) -> Self {
        Self {
            channel: Arc::clone(channel),
            messages: 0,
            times: Times::default(),
            joints: BTreeMap::new(),
            frames: BTreeMap::new(),
            description: None,
            frame: None,
            told: Told::default(),
        }
    }

    /// Name of the message type without its package.
    pub(super) fn type_name(&self) -> &str {
        self.channel.schema.rsplit('/').next().unwrap_or_default()
    }

    /// Whether its messages are lists of transforms.
    pub(super) fn has_transforms(&self) -> bool {
        matches!(self.type_name(), "TFMessage" | "tfMessage")
    }

    /// Whether it is an odometry whose pose moves although its speeds are zero throughout.
    pub(super) fn has_idle_twist(&self) -> bool {
        self.told.moves && !self.told.has_speed
    }

    fn add(&mut self, log_ns: i64, data: &[u8]) -> VisitResult {
        self.messages += 1;
        let Some(encoding) = Encoding::of(&self.channel.encoding) else {
            return Ok(());
        };
        let stamp_ns = match self.type_name() {
            "JointState" => self.add_joints(encoding, data)?,
            "TFMessage" | "tfMessage" => self.add_frames(encoding, data)?,
            "String" if has_description(&self.channel) => {
                self.add_description(encoding, data)?;
                None
            }
            _ => match Sample::decode(&self.channel, &MessageSelector::default(), data) {
                Ok(sample) => {
                    if self.type_name() == "Odometry" {
                        self.told.add(&sample);
                    }
                    sample.t_ns
                }
                Err(NoSample::NotSelected) => return Ok(()),
                Err(NoSample::Undecodable) => return Err(Undecodable),
            },
        };
        if self.messages == 1 && stamp_ns.is_some() && self.frames.is_empty() {
            let header: Result<Header<String>, _> = encoding.decode_stamped(data);
            self.frame = header.ok().map(|header| header.frame_id);
        }
        self.times.add(stamp_ns, log_ns);
        Ok(())
    }

    fn add_description(&mut self, encoding: Encoding, data: &[u8]) -> VisitResult {
        if data.len() <= MOST_DESCRIPTION_BYTES {
            let text: String = encoding.decode(data).map_err(|_| Undecodable)?;
            self.description = Some(text);
        }
        Ok(())
    }

    /// Returns the message's stamp (ns).
    fn add_joints(&mut self, encoding: Encoding, data: &[u8]) -> Result<Option<i64>, Undecodable> {
        let state: JointState = encoding.decode_stamped(data).map_err(|_| Undecodable)?;
        for (i, name) in state.name.into_iter().enumerate() {
            if self.joints.len() < MOST_NAMES || self.joints.contains_key(&name) {
                let joint = self.joints.entry(name).or_default();
                joint.angle.add(&state.position, i);
                joint.speed.add(&state.velocity, i);
                joint.torque.add(&state.effort, i);
            }
        }
        Ok(Some(state.header.stamp.ns()))
    }

    /// Returns the stamp of the first transform (ns).
    fn add_frames(&mut self, encoding: Encoding, data: &[u8]) -> Result<Option<i64>, Undecodable> {
        let transforms = encoding.decode_transforms(data).map_err(|_| Undecodable)?;
        let stamp_ns = transforms.first().map(|first| first.header.stamp.ns());
        for transform in transforms {
            let place = rigid::of_message(&transform);
            let frames = [transform.header.frame_id, transform.child_frame_id];
            if self.frames.len() < MOST_NAMES || self.frames.contains_key(&frames) {
                let seen = self.frames.entry(frames).or_default();
                seen.count += 1;
                seen.varies |= seen.place.is_some() && place.is_some() && seen.place != place;
                seen.place = place.or(seen.place);
            }
        }
        Ok(stamp_ns)
    }
}
