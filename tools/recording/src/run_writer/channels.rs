//! Channels of a run's file, each opened when its first message is written.

use std::collections::BTreeMap;

use slipstream_bag::ros::MessageType;
use slipstream_bag::{BagWriter, Channel, Result};
use slipstream_bus::experiment::{Drive, WheelSource};

use super::header::RunHeader;
use crate::table::{LINK_COLUMNS, StreamKind};
use crate::topics::{self, StreamMetadata, robot_topic, standard_type};

/// The topics of one robot.
#[derive(Debug, Clone, Copy)]
pub(super) enum RobotTopic {
    /// Torques.
    Command,
    /// Twists.
    TwistCommand,
    Encoders,
    /// True angles and speeds, for viewers.
    Wheels,
    /// Angles as a real robot sends them.
    WheelAngles,
    Camera,
    Odometry,
    Imu,
    Truth,
    Contact,
}

/// The topics that belong to no robot.
#[derive(Debug, Clone, Copy)]
pub(super) enum SharedTopic {
    TruePoses,
    Positions,
    Trace,
    Events,
}

/// The channels that are open.
#[derive(Debug)]
pub(super) struct Channels {
    robots: Vec<RobotChannels>,
    /// By [`SharedTopic`].
    shared: [Option<Channel>; 4],
}

#[derive(Debug, Clone)]
struct RobotChannels {
    name: String,
    /// What the run may write.
    topics: Vec<RobotTopic>,
    /// By [`RobotTopic`].
    open: [Option<Channel>; 10],
}

/// A stream and its columns.
type StreamLayout = (StreamKind, &'static str);

impl RobotTopic {
    /// What a run may write of a robot.
    fn of(drive: Drive, wheels: WheelSource) -> Vec<Self> {
        let command = match drive {
            Drive::Torque => Self::Command,
            Drive::Twist => Self::TwistCommand,
        };
        let measured: &[Self] = match wheels {
            WheelSource::Simulated => &[
                Self::Encoders,
                Self::Wheels,
                Self::Camera,
                Self::Odometry,
                Self::Imu,
                Self::Truth,
                Self::Contact,
            ],
            WheelSource::Angles | WheelSource::AnglesAndOdometry => {
                &[Self::WheelAngles, Self::Camera, Self::Odometry, Self::Imu]
            }
            WheelSource::Odometry => &[Self::Camera, Self::Odometry, Self::Imu],
        };
        std::iter::once(command)
            .chain(measured.iter().copied())
            .collect()
    }

    /// Message type, last part of the topic, and the stream that slipstream reads from the channel
    /// with its columns. Topics without a stream are for viewers.
    fn definition(self) -> (MessageType, &'static str, Option<StreamLayout>) {
        let stream = |kind, columns: &'static str| {
            let (first, _) = columns.split_once(',').unwrap_or_default();
            let (message_type, name) = standard_type(kind, first);
            (message_type, name, Some((kind, columns)))
        };
        match self {
            Self::Command => stream(StreamKind::Command, "torque_right_nm,torque_left_nm"),
            Self::TwistCommand => stream(StreamKind::Command, "v_m_s,w_rad_s"),
            Self::Encoders => stream(StreamKind::Wheels, "ticks_right,ticks_left"),
            Self::Wheels => (MessageType::JointState, "joint_states", None),
            Self::WheelAngles => stream(StreamKind::Wheels, "angle_right_rad,angle_left_rad"),
            Self::Camera => stream(StreamKind::Pose, "x_m,y_m,yaw_rad"),
            // Its pose is for viewers.
            Self::Odometry => {
                let (_, name, stream) = stream(StreamKind::Odometry, "v_m_s,w_rad_s");
                (MessageType::Odometry, name, stream)
            }
            Self::Imu => stream(StreamKind::Imu, "ax_m_s2,ay_m_s2,gz_rad_s"),
            Self::Truth => (MessageType::Odometry, "truth", None),
            Self::Contact => (MessageType::Contact, "contact", None),
        }
    }

    /// Channel metadata.
    fn metadata(self, robot: &str) -> BTreeMap<String, String> {
        let (_, _, stream) = self.definition();
        stream
            .map(|(kind, columns)| StreamMetadata::of_robot(robot, kind, columns).to_map())
            .unwrap_or_default()
    }
}

impl SharedTopic {
    const ALL: [Self; 4] = [Self::TruePoses, Self::Positions, Self::Trace, Self::Events];

    /// Message type and topic.
    fn definition(self) -> (MessageType, &'static str) {
        match self {
            Self::TruePoses => (MessageType::TfMessage, topics::TF),
            Self::Positions => (MessageType::PositionMessage, topics::LINKS),
            Self::Trace => (MessageType::TraceEvent, topics::TRACE),
            Self::Events => (MessageType::Event, topics::EVENTS),
        }
    }

    /// Channel metadata.
    fn metadata(self) -> BTreeMap<String, String> {
        match self {
            Self::Positions => StreamMetadata {
                stream: topics::LINK_STREAM.to_owned(),
                columns: LINK_COLUMNS
                    .iter()
                    .skip(1)
                    .map(|&name| name.to_owned())
                    .collect(),
                unknown: Vec::new(),
            }
            .to_map(),
            Self::TruePoses | Self::Trace | Self::Events => BTreeMap::new(),
        }
    }
}

impl Channels {
    /// No open channels, for the robots of a run.
    pub(super) fn new(run: &RunHeader) -> Self {
        let wheels = run.wheels.iter().copied();
        let wheels = wheels.chain(std::iter::repeat(WheelSource::Simulated));
        let robots = run.description.robots.iter().zip(wheels);
        let robots = robots.map(|(robot, wheels)| RobotChannels {
            name: robot.name.clone(),
            topics: RobotTopic::of(run.drive, wheels),
            open: [None; 10],
        });
        Self {
            robots: robots.collect(),
            shared: [None; 4],
        }
    }

    /// Every topic that the run may write, with its type and its metadata.
    pub(super) fn topics(&self) -> Vec<(String, MessageType, BTreeMap<String, String>)> {
        let of_robots = self.robots.iter().flat_map(|robot| {
            robot.topics.iter().map(|topic| {
                let (message_type, name, _) = topic.definition();
                let metadata = topic.metadata(&robot.name);
                (robot_topic(&robot.name, name), message_type, metadata)
            })
        });
        let shared = SharedTopic::ALL.map(|topic| {
            let (message_type, name) = topic.definition();
            (name.to_owned(), message_type, topic.metadata())
        });
        of_robots.chain(shared).collect()
    }

    /// Names of the robots, in order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.robots.iter().map(|robot| robot.name.as_str())
    }

    /// Name of a robot; empty if there is no such robot.
    pub(super) fn name(&self, robot: usize) -> &str {
        self.robots
            .get(robot)
            .map_or("", |robot| robot.name.as_str())
    }

    /// The channel of a robot's topic; `None` if there is no such robot.
    pub(super) fn of_robot(
        &mut self,
        bag: &mut BagWriter<'_>,
        robot: usize,
        topic: RobotTopic,
    ) -> Result<Option<Channel>> {
        let Some(RobotChannels { name, open, .. }) = self.robots.get_mut(robot) else {
            return Ok(None);
        };
        let slot = &mut open[topic as usize];
        if slot.is_none() {
            let (message_type, last, _) = topic.definition();
            let metadata = topic.metadata(name);
            *slot = Some(bag.channel(&robot_topic(name, last), message_type, &metadata)?);
        }
        Ok(*slot)
    }

    /// The channel of a topic that belongs to no robot.
    pub(super) fn shared(
        &mut self,
        bag: &mut BagWriter<'_>,
        topic: SharedTopic,
    ) -> Result<Channel> {
        let slot = &mut self.shared[topic as usize];
        match slot {
            Some(channel) => Ok(*channel),
            None => {
                let (message_type, name) = topic.definition();
                Ok(*slot.insert(bag.channel(name, message_type, &topic.metadata())?))
            }
        }
    }
}
