//! The quantities in one message of any supported type; NaN where the message has none.

use slipstream_bag::ChannelInfo;
use slipstream_bag::ros::Encoding;
use slipstream_bag::ros::compose::JOINTS;
use slipstream_bag::ros::messages::{self as ros, Header, Pose, Twist};

/// Selects one robot's part of a message that describes several joints or frames.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct MessageSelector {
    /// Names of the wheels' joints, [right, left]. Several on one side (skid steering) give their mean.
    pub(crate) joints: [Vec<String>; 2],
    /// In a list of transforms, the child frame to read.
    pub(crate) frame: Option<String>,
    /// The parent frame of that transform; any, if `None`.
    pub(crate) parent: Option<String>,
}

impl Default for MessageSelector {
    fn default() -> Self {
        Self {
            joints: JOINTS.map(|joint| vec![joint.to_owned()]),
            frame: None,
            parent: None,
        }
    }
}

/// The quantities of a message. Pairs are [right, left].
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    /// Time stamp of the message (ns), if it has one.
    pub(crate) t_ns: Option<i64>,
    /// Encoder counts.
    pub(crate) ticks: [Option<i64>; 2],
    /// x (m), y (m), yaw (rad).
    pub(super) pose: [f64; 3],
    /// Forward speed (m/s), yaw rate (rad/s).
    pub(super) twist: [f64; 2],
    /// Wheel angles (rad).
    angle: [f64; 2],
    /// Wheel speeds (rad/s).
    speed: [f64; 2],
    /// Wheel torques (N m).
    torque: [f64; 2],
    /// Motor voltages (V).
    voltage: [f64; 2],
    /// Acceleration forward and to the left (m/s²).
    acceleration: [f64; 2],
    /// Yaw rate of the gyro (rad/s).
    yaw_rate: f64,
    /// Current right (A), current left (A), supply voltage (V).
    motor: [f64; 3],
}

/// Why a message gives no sample.
#[derive(Debug)]
pub(crate) enum NoSample {
    /// It cannot be decoded.
    Undecodable,
    /// It has another type, or describes other frames or joints than the selected ones.
    NotSelected,
}

impl From<String> for NoSample {
    fn from(_: String) -> Self {
        Self::Undecodable
    }
}

impl Sample {
    /// A sample without quantities.
    pub(super) fn empty(t_ns: Option<i64>) -> Self {
        const NAN: f64 = f64::NAN;
        Self {
            t_ns,
            ticks: [None; 2],
            pose: [NAN; 3],
            twist: [NAN; 2],
            angle: [NAN; 2],
            speed: [NAN; 2],
            torque: [NAN; 2],
            voltage: [NAN; 2],
            acceleration: [NAN; 2],
            yaw_rate: NAN,
            motor: [NAN; 3],
        }
    }

    fn stamped(header: &Header<String>) -> Self {
        Self::empty(Some(header.stamp.ns()))
    }

    /// The number for a column of the format; NaN if the message does not contain it.
    pub(crate) fn number(&self, column: &str) -> f64 {
        match column {
            "x_m" => self.pose[0],
            "y_m" => self.pose[1],
            "yaw_rad" => self.pose[2],
            "v_m_s" => self.twist[0],
            "w_rad_s" => self.twist[1],
            "angle_right_rad" => self.angle[0],
            "angle_left_rad" => self.angle[1],
            "speed_right_rad_s" => self.speed[0],
            "speed_left_rad_s" => self.speed[1],
            "torque_right_nm" => self.torque[0],
            "torque_left_nm" => self.torque[1],
            "voltage_right_v" => self.voltage[0],
            "voltage_left_v" => self.voltage[1],
            "ax_m_s2" => self.acceleration[0],
            "ay_m_s2" => self.acceleration[1],
            "gz_rad_s" => self.yaw_rate,
            "current_right_a" => self.motor[0],
            "current_left_a" => self.motor[1],
            "supply_v" => self.motor[2],
            _ => f64::NAN,
        }
    }

    fn with_pose(mut self, pose: &Pose) -> Self {
        self.pose = [pose.position.x, pose.position.y, pose.orientation.yaw()];
        self
    }

    fn with_twist(mut self, twist: &Twist) -> Self {
        self.twist = [twist.linear.x, twist.angular.z];
        self
    }

    /// Decodes a message of a supported type.
    ///
    /// # Errors
    /// If it cannot be decoded, has another type, or contains nothing selected.
    pub(crate) fn decode(
        channel: &ChannelInfo,
        selector: &MessageSelector,
        data: &[u8],
    ) -> Result<Self, NoSample> {
        let encoding = Encoding::of(&channel.encoding).ok_or(NoSample::NotSelected)?;
        Ok(match channel.schema.as_str() {
            "sensor_msgs/msg/JointState" => joint_state(encoding, selector, data)?,
            "geometry_msgs/msg/PoseStamped" => {
                let message: ros::PoseStamped<String> = encoding.decode_stamped(data)?;
                Self::stamped(&message.header).with_pose(&message.pose)
            }
            "geometry_msgs/msg/PoseWithCovarianceStamped" => {
                let message: ros::PoseWithCovarianceStamped<String> =
                    encoding.decode_stamped(data)?;
                Self::stamped(&message.header).with_pose(&message.pose)
            }
            "geometry_msgs/msg/TransformStamped" => {
                Self::of_transform(&encoding.decode_stamped(data)?)
            }
            "geometry_msgs/msg/PointStamped" => {
                let message: ros::PointStamped<String> = encoding.decode_stamped(data)?;
                let mut sample = Self::stamped(&message.header);
                sample.pose = [message.point.x, message.point.y, f64::NAN];
                sample
            }
            "geometry_msgs/msg/Pose" => Self::empty(None).with_pose(&encoding.decode(data)?),
            "geometry_msgs/msg/Twist" => Self::empty(None).with_twist(&encoding.decode(data)?),
            // A covariance may follow.
            "geometry_msgs/msg/TwistStamped" | "geometry_msgs/msg/TwistWithCovarianceStamped" => {
                let message: ros::TwistStamped<String> = encoding.decode_stamped(data)?;
                Self::stamped(&message.header).with_twist(&message.twist)
            }
            "nav_msgs/msg/Odometry" => {
                let message: ros::Odometry<String> = encoding.decode_stamped(data)?;
                Self::stamped(&message.header)
                    .with_pose(&message.pose)
                    .with_twist(&message.twist)
            }
            name if name.ends_with(TRANSFORMS) => transform(encoding, selector, data)?,
            "sensor_msgs/msg/Imu" => imu(encoding, data)?,
            "slipstream_msgs/msg/EncoderTicks" => {
                let message: ros::EncoderTicks<String> = encoding.decode_stamped(data)?;
                let ticks = [Some(message.right), Some(message.left)];
                Self {
                    ticks,
                    ..Self::stamped(&message.header)
                }
            }
            "slipstream_msgs/msg/WheelVoltage" => {
                let message: ros::WheelVoltage<String> = encoding.decode_stamped(data)?;
                let voltage = [message.right_v, message.left_v];
                Self {
                    voltage,
                    ..Self::stamped(&message.header)
                }
            }
            "struct:Pose2d" => {
                let mut sample = Self::empty(None);
                sample.pose = encoding.decode(data)?;
                sample
            }
            "struct:ChassisSpeeds" => {
                let [v_m_s, _, w_rad_s]: [f64; 3] = encoding.decode(data)?;
                let mut sample = Self::empty(None);
                sample.twist = [v_m_s, w_rad_s];
                sample
            }
            "slipstream_msgs/msg/MotorState" => motor_state(encoding, data)?,
            _ => return Err(NoSample::NotSelected),
        })
    }

    /// Whether messages of a channel can give a sample. No message of a known type is empty.
    pub(crate) fn can_be_of(channel: &ChannelInfo) -> bool {
        let decoded = Self::decode(channel, &MessageSelector::default(), &[]);
        !matches!(decoded, Err(NoSample::NotSelected))
    }

    fn of_transform(transform: &ros::TransformStamped<String>) -> Self {
        let pose = Pose {
            position: transform.translation,
            orientation: transform.rotation,
        };
        Self::stamped(&transform.header).with_pose(&pose)
    }
}

/// End of the names of the types of transforms: `tf2_msgs/msg/TFMessage`, in old bags `tf/msg/tfMessage`.
const TRANSFORMS: &str = "FMessage";

/// A joint state with its own lists.
pub(crate) type JointState = ros::JointState<String, Vec<String>, Vec<f64>>;

fn joint_state(
    encoding: Encoding,
    selector: &MessageSelector,
    data: &[u8],
) -> Result<Sample, NoSample> {
    let message: JointState = encoding.decode_stamped(data)?;
    let index = |joint: &String| message.name.iter().position(|name| name == joint);
    let indices = selector
        .joints
        .each_ref()
        .map(|side| side.iter().map(index).collect::<Option<Vec<usize>>>());
    if indices == [None, None] {
        return Err(NoSample::NotSelected);
    }
    let both = |values: &[f64]| {
        indices.each_ref().map(|side| {
            let side = side.as_deref().unwrap_or_default();
            let values = side
                .iter()
                .map(|i| values.get(*i).copied().unwrap_or(f64::NAN));
            // Of none, this is NaN.
            values.sum::<f64>() / side.len() as f64
        })
    };
    let mut sample = Sample::stamped(&message.header);
    sample.angle = both(&message.position);
    sample.speed = both(&message.velocity);
    sample.torque = both(&message.effort);
    Ok(sample)
}

fn transform(
    encoding: Encoding,
    selector: &MessageSelector,
    data: &[u8],
) -> Result<Sample, NoSample> {
    let transforms = encoding.decode_transforms(data)?;
    let is_selected = |transform: &&ros::TransformStamped<String>| {
        let parent = selector.parent.as_ref();
        selector.frame.as_ref() == Some(&transform.child_frame_id)
            && parent.is_none_or(|parent| *parent == transform.header.frame_id)
    };
    let transform = transforms.iter().find(is_selected);
    Ok(Sample::of_transform(
        transform.ok_or(NoSample::NotSelected)?,
    ))
}

fn imu(encoding: Encoding, data: &[u8]) -> Result<Sample, NoSample> {
    let message: ros::Imu<String> = encoding.decode_stamped(data)?;
    let acceleration = message.linear_acceleration;
    let mut sample = Sample::stamped(&message.header);
    // A covariance of -1 marks a quantity as not measured (ROS convention).
    if message.linear_acceleration_covariance[0] != -1.0 {
        sample.acceleration = [acceleration.x, acceleration.y];
    }
    if message.angular_velocity_covariance[0] != -1.0 {
        sample.yaw_rate = message.angular_velocity.z;
    }
    Ok(sample)
}

fn motor_state(encoding: Encoding, data: &[u8]) -> Result<Sample, NoSample> {
    let message: ros::MotorState<String> = encoding.decode_stamped(data)?;
    let mut sample = Sample::stamped(&message.header);
    sample.motor = [
        message.current_right_a,
        message.current_left_a,
        message.supply_v,
    ];
    Ok(sample)
}
