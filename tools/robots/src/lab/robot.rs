//! The robots of a lab, as plain data.

use std::path::PathBuf;

use slipstream_bus::experiment::Drive;
use slipstream_bus::message::{Actuation, RobotIndex};
use slipstream_bus::{Settings, TwistLimits};
use slipstream_hosts::address::{Address, Security};

/// The robots of a lab, from the front of the formation.
#[derive(Debug, Clone, PartialEq)]
pub struct Lab {
    /// The file.
    pub path: PathBuf,
    /// How topics are named and messages sent on the network.
    pub wire: Wire,
    /// How the connections are protected.
    pub security: Security,
    /// The robots `r1`, `r2` …
    pub robots: Vec<LabRobot>,
}

/// How ROS 2 topics are carried over Zenoh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wire {
    /// `zenoh-bridge-ros2dds`: the key is the topic.
    Ros2dds,
    /// `rmw_zenoh`: the key has domain, topic, type and hash of the type, and messages have an attachment.
    RmwZenoh {
        /// `ROS_DOMAIN_ID`.
        domain: u32,
    },
}

/// A robot of the lab.
#[derive(Debug, Clone, PartialEq)]
pub struct LabRobot {
    /// Its name in the experiment.
    pub name: String,
    /// Where its bridge or router listens.
    pub address: Address,
    /// Its nominal model.
    pub model: PathBuf,
    /// Where it stands at the start: x (m), y (m), yaw (rad) of c; as in the experiment if it is not said.
    pub start: Option<[f64; 3]>,
    /// What it is told.
    pub command: CommandTopic,
    /// What its wheels do.
    pub wheels: WheelTopic,
    /// The topic of its own odometry, `nav_msgs/msg/Odometry`, beside that of its wheels. It is recorded.
    pub odometry: Option<String>,
    /// The topic of its inertial sensor, `sensor_msgs/msg/Imu`. It is recorded.
    pub imu: Option<String>,
    /// Where it is, by motion capture or a camera.
    pub pose: Option<PoseTopic>,
    /// What it may be told.
    pub limits: TwistLimits,
}

/// The topic of commands.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandTopic {
    /// The topic, without the leading `/`.
    pub topic: String,
    /// What it takes.
    pub message: CommandMessage,
}

/// The message of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CommandMessage {
    /// `geometry_msgs/msg/Twist`.
    Twist,
    /// `geometry_msgs/msg/TwistStamped`.
    TwistStamped,
    /// `std_msgs/msg/Float64MultiArray`: torques of the two wheels, as `ros2_control`'s controllers of efforts take them.
    Efforts {
        /// Whether the left wheel comes first.
        left_first: bool,
        /// Largest torque of a wheel (N m).
        torque_nm: f64,
    },
}

impl CommandMessage {
    /// What the robot is told by it.
    pub fn drive(&self) -> Drive {
        match self {
            Self::Twist | Self::TwistStamped => Drive::Twist,
            Self::Efforts { .. } => Drive::Torque,
        }
    }

    /// What lets the robot stand; one that takes torques rolls out.
    pub fn rest(&self) -> Actuation {
        match self.drive() {
            Drive::Twist => Actuation::Twist([0.0; 2]),
            Drive::Torque => Actuation::Torque([0.0; 2]),
        }
    }
}

/// The topic that tells what the wheels do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WheelTopic {
    /// `sensor_msgs/msg/JointState`.
    Joints {
        /// The topic.
        topic: String,
        /// Names of the right and of the left joint.
        joints: [String; 2],
    },
    /// `nav_msgs/msg/Odometry`.
    Odometry {
        /// The topic.
        topic: String,
    },
}

/// The topic of poses, `geometry_msgs/msg/PoseStamped`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PoseTopic {
    /// The topic.
    pub topic: String,
    /// Whether the middle of the axle is tracked; else the centre of mass c.
    pub is_axle: bool,
}

impl WheelTopic {
    /// The topic's name.
    pub fn topic(&self) -> &str {
        match self {
            Self::Joints { topic, .. } | Self::Odometry { topic } => topic,
        }
    }
}

impl Lab {
    /// What the robots are told; all take the same.
    pub fn drive(&self) -> Drive {
        let front = self.robots.first();
        front.map_or(Drive::Twist, |robot| robot.command.message.drive())
    }

    /// The smallest of each limit.
    pub fn limits(&self) -> TwistLimits {
        let limits = self.robots.iter().map(|robot| robot.limits);
        limits.fold(TwistLimits::NONE, |all, own| all.both(&own))
    }

    /// Where a robot stands at the start: as the file says, else in a row, as in the paper's platoon.
    pub fn start_pose(&self, index: RobotIndex) -> [f64; 3] {
        let own = self.robots.get(index as usize).and_then(|own| own.start);
        own.unwrap_or_else(|| Settings::default().start_pose(index))
    }

    /// The addresses to connect to, each once.
    pub fn addresses(&self) -> Vec<&Address> {
        let mut addresses: Vec<&Address> = Vec::new();
        for robot in &self.robots {
            if !addresses.contains(&&robot.address) {
                addresses.push(&robot.address);
            }
        }
        addresses
    }
}
