//! The keys of `robots.toml`, as they stand in the file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use slipstream_bus::TwistLimits;

/// The file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) format: u32,
    /// `ros2dds` or `rmw_zenoh`.
    #[serde(default = "ros2dds")]
    pub(super) wire: String,
    /// `ROS_DOMAIN_ID`, for `rmw_zenoh`.
    #[serde(default)]
    pub(super) domain: u32,
    /// Where the bridge or router of all robots listens.
    pub(super) connect: Option<String>,
    /// Folder of certificates (`slipstream keys`).
    pub(super) tls: Option<PathBuf>,
    /// The network is trusted.
    #[serde(default)]
    pub(super) insecure: bool,
    /// Limits of all robots.
    pub(super) limits: Option<TwistLimits>,
    pub(super) robots: BTreeMap<String, Robot>,
}

/// A robot.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Robot {
    pub(super) connect: Option<String>,
    pub(super) model: PathBuf,
    pub(super) start: Option<[f64; 3]>,
    pub(super) command: Command,
    pub(super) wheels: Option<Wheels>,
    pub(super) odometry: Option<Topic>,
    pub(super) imu: Option<Topic>,
    pub(super) pose: Option<Pose>,
    pub(super) limits: Option<TwistLimits>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Command {
    pub(super) topic: String,
    /// `Twist`, `TwistStamped` or `Float64MultiArray`.
    #[serde(rename = "type")]
    pub(super) message: MessageName,
    /// Order of the wheels in a `Float64MultiArray`.
    pub(super) order: Option<Order>,
    /// Largest torque of a wheel (N m), for a `Float64MultiArray`.
    pub(super) torque_nm: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Order {
    RightLeft,
    LeftRight,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub(super) enum MessageName {
    #[serde(alias = "geometry_msgs/msg/Twist")]
    Twist,
    #[serde(alias = "geometry_msgs/msg/TwistStamped")]
    TwistStamped,
    #[serde(alias = "std_msgs/msg/Float64MultiArray")]
    Float64MultiArray,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wheels {
    pub(super) topic: String,
    /// Name of the right joint.
    pub(super) right: String,
    /// Name of the left joint.
    pub(super) left: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Topic {
    pub(super) topic: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Pose {
    pub(super) topic: String,
    /// `centre_of_mass` or `axle`.
    #[serde(default)]
    pub(super) point: Point,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Point {
    #[default]
    CentreOfMass,
    Axle,
}

fn ros2dds() -> String {
    "ros2dds".to_owned()
}
