//! Survey of a bag: its topics, and what their messages contain.

use std::collections::BTreeMap;
use std::sync::Arc;

use slipstream_bag::ros::messages::Header;
use slipstream_bag::ros::{Encoding, Layout};
use slipstream_bag::{Bag, ChannelInfo, Item, Loss, Undecodable, VisitResult};
use slipstream_bus::InputError;

use super::clock::Times;
use super::numbers::{Numbers, layout_of_wheels};
use super::rigid::{self, Rigid};
use super::turn::Turned;
use crate::decode::{JointState, MessageSelector, NoSample, Sample, Stamp, layout_of};

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
    /// The numbers that may be those of wheels, by their paths.
    pub(super) numbers: BTreeMap<String, Numbers>,
    layout: Option<Layout>,
    /// The last description of a robot (URDF).
    pub(super) description: Option<String>,
    /// The frame of the first message's header.
    pub(super) frame: Option<String>,
    /// What an odometry tells of its motion.
    told: ToldMotion,
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
    /// Whether it turns as a wheel does.
    pub(super) turned: Turned,
}

/// What an odometry tells of its motion.
#[derive(Debug, Default)]
struct ToldMotion {
    /// The first pose: x (m), y (m), yaw (rad).
    first: Option<[f64; 3]>,
    /// Whether a pose was another than the first.
    moves: bool,
    /// Whether a speed was not zero.
    has_speed: bool,
}

impl ToldMotion {
    fn add(&mut self, sample: &Sample) {
        let pose = ["x_m", "y_m", "yaw_rad"].map(|name| sample.number(name));
        self.moves |= *self.first.get_or_insert(pose) != pose;
        let speeds = ["v_m_s", "w_rad_s"].map(|name| sample.number(name));
        self.has_speed |= speeds.iter().any(|own| own.is_finite() && *own != 0.0);
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

/// The topics of a bag, sorted by name, and what could not be read. The numbers of `mapped` topics are read whatever their names.
///
/// # Errors
/// If it is not a bag, or cannot be read.
pub(super) fn survey(bag: &dyn Bag, mapped: &[&str]) -> Result<(Vec<Topic>, Loss), InputError> {
    let layout = |channel: &ChannelInfo| layout(channel, mapped);
    // Of other topics, such as images, only the number of messages counts.
    let is_of_interest = |channel: &ChannelInfo| is_of_interest(channel, mapped);
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let loss = bag.scan(&is_of_interest, &mut |item| {
        let (Item::Message { channel, .. } | Item::Unwanted { channel, .. }) = item else {
            return Ok(());
        };
        let topic = match topics.get_mut(&channel.topic) {
            Some(topic) => topic,
            None => topics
                .entry(channel.topic.clone())
                .or_insert_with(|| Topic::new(channel, layout(channel))),
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

/// Where the numbers of a message are that may be those of wheels; of `mapped` topics, all numbers.
fn layout(channel: &ChannelInfo, mapped: &[&str]) -> Option<Layout> {
    match mapped.contains(&channel.topic.as_str()) {
        true => layout_of(channel).filter(|_| !Sample::can_be_of(channel)),
        false => layout_of_wheels(channel),
    }
}

/// Whether the messages of a topic may tell something of a robot.
pub(crate) fn is_of_interest(channel: &ChannelInfo, mapped: &[&str]) -> bool {
    Sample::can_be_of(channel) || has_description(channel) || layout(channel, mapped).is_some()
}

/// Whether the texts of a topic describe a robot.
fn has_description(channel: &ChannelInfo) -> bool {
    channel.topic.ends_with("robot_description") && channel.schema.ends_with("/String")
}

impl Topic {
    fn new(channel: &Arc<ChannelInfo>, layout: Option<Layout>) -> Self {
        Self {
            channel: Arc::clone(channel),
            messages: 0,
            times: Times::default(),
            joints: BTreeMap::new(),
            frames: BTreeMap::new(),
            numbers: BTreeMap::new(),
            layout,
            description: None,
            frame: None,
            told: ToldMotion::default(),
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

    /// Whether it is an odometry whose pose moves although its speeds are zero or no numbers throughout.
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
            _ if self.layout.is_some() => self.add_numbers(encoding, data)?,
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
        if self.messages == 1
            && stamp_ns.is_some()
            && self.frames.is_empty()
            && self.layout.is_none()
        {
            let header: Result<Header<String>, _> = encoding.decode_stamped(data);
            self.frame = header.ok().map(|header| header.frame_id);
        }
        self.times.add(stamp_ns, log_ns);
        Ok(())
    }

    /// Returns the message's stamp (ns), if it has one.
    fn add_numbers(&mut self, encoding: Encoding, data: &[u8]) -> Result<Option<i64>, Undecodable> {
        let mut stamp = Stamp::default();
        let (layout, numbers) = (&self.layout, &mut self.numbers);
        let Some(layout) = layout else {
            return Ok(None);
        };
        let read = layout.numbers(encoding, data, &mut |path, number| {
            if stamp.add(path, number.value) {
                return;
            }
            let is_full = numbers.len() >= MOST_NAMES;
            match numbers.get_mut(path) {
                Some(seen) => seen.add(number.value),
                None if is_full => {}
                None => {
                    let mut seen = Numbers::new(number.is_whole);
                    seen.add(number.value);
                    numbers.insert(path.to_owned(), seen);
                }
            }
        });
        read.map_err(|_| Undecodable)?;
        Ok(stamp.ns())
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
                if let Some(place) = &place {
                    seen.turned.add(place);
                }
            }
        }
        Ok(stamp_ns)
    }
}
