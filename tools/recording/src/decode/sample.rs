//! What one message says, whatever its type: one place per quantity, NaN where it says nothing.

use crate::ros2::cdr::decode;
use crate::ros2::compose::JOINTS;
use crate::ros2::messages::{self as ros, Header, Pose, Twist};

/// Where to look inside a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Pick {
    /// Names of the right and the left wheel's joints.
    pub(crate) joints: [String; 2],
    /// Of a list of transforms, the one to this frame.
    pub(crate) frame: Option<String>,
}

impl Default for Pick {
    fn default() -> Self {
        Self {
            joints: JOINTS.map(str::to_owned),
            frame: None,
        }
    }
}

/// The quantities of a message.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    /// The stamp in the message (ns), where it has one.
    pub(crate) t_ns: Option<i64>,
    /// Counts, [right, left].
    pub(crate) ticks: [Option<i64>; 2],
    pose: [f64; 3],
    twist: [f64; 2],
    angle: [f64; 2],
    speed: [f64; 2],
    torque: [f64; 2],
    voltage: [f64; 2],
    acceleration: [f64; 2],
    yaw_rate: f64,
    motor: [f64; 3],
}

/// What a message had nothing of.
#[derive(Debug)]
pub(crate) enum Nothing {
    /// It cannot be decoded.
    Undecodable,
    /// It is about something else (another frame, other joints).
    Elsewhere,
}

impl From<String> for Nothing {
    fn from(_: String) -> Self {
        Self::Undecodable
    }
}

impl Sample {
    fn at(t_ns: Option<i64>) -> Self {
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
        Self::at(Some(header.stamp.ns()))
    }

    /// The number that belongs into a column of the format; NaN where the message says none.
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

    /// Decodes a message of one of the types that hold quantities of the format.
    pub(crate) fn decode(schema: &str, pick: &Pick, data: &[u8]) -> Result<Self, Nothing> {
        Ok(match schema {
            "sensor_msgs/msg/JointState" => joint_state(pick, data)?,
            "geometry_msgs/msg/PoseStamped" => {
                let message: ros::PoseStamped<String> = decode(data)?;
                Self::stamped(&message.header).with_pose(&message.pose)
            }
            "geometry_msgs/msg/PoseWithCovarianceStamped" => {
                let message: ros::PoseWithCovarianceStamped<String> = decode(data)?;
                Self::stamped(&message.header).with_pose(&message.pose)
            }
            "geometry_msgs/msg/Pose" => Self::at(None).with_pose(&decode(data)?),
            "geometry_msgs/msg/Twist" => Self::at(None).with_twist(&decode(data)?),
            "geometry_msgs/msg/TwistStamped" => {
                let message: ros::TwistStamped<String> = decode(data)?;
                Self::stamped(&message.header).with_twist(&message.twist)
            }
            "nav_msgs/msg/Odometry" => {
                let message: ros::Odometry<String> = decode(data)?;
                Self::stamped(&message.header)
                    .with_pose(&message.pose)
                    .with_twist(&message.twist)
            }
            "tf2_msgs/msg/TFMessage" => transform(pick, data)?,
            "sensor_msgs/msg/Imu" => {
                let message: ros::Imu<String> = decode(data)?;
                let acceleration = message.linear_acceleration;
                let mut sample = Self::stamped(&message.header);
                // A covariance of -1 says that the quantity was not measured.
                if message.linear_acceleration_covariance[0] != -1.0 {
                    sample.acceleration = [acceleration.x, acceleration.y];
                }
                if message.angular_velocity_covariance[0] != -1.0 {
                    sample.yaw_rate = message.angular_velocity.z;
                }
                sample
            }
            "slipstream_msgs/msg/EncoderTicks" => {
                let message: ros::EncoderTicks<String> = decode(data)?;
                let mut sample = Self::stamped(&message.header);
                sample.ticks = [Some(message.right), Some(message.left)];
                sample
            }
            "slipstream_msgs/msg/WheelVoltage" => {
                let message: ros::WheelVoltage<String> = decode(data)?;
                let mut sample = Self::stamped(&message.header);
                sample.voltage = [message.right_v, message.left_v];
                sample
            }
            "slipstream_msgs/msg/MotorState" => {
                let message: ros::MotorState<String> = decode(data)?;
                let mut sample = Self::stamped(&message.header);
                sample.motor = [
                    message.current_right_a,
                    message.current_left_a,
                    message.supply_v,
                ];
                sample
            }
            _ => return Err(Nothing::Elsewhere),
        })
    }
}

type JointState = ros::JointState<String, Vec<String>, Vec<f64>>;

fn joint_state(pick: &Pick, data: &[u8]) -> Result<Sample, Nothing> {
    let message: JointState = decode(data)?;
    let place = |joint: &String| message.name.iter().position(|name| name == joint);
    let places = [place(&pick.joints[0]), place(&pick.joints[1])];
    if places == [None, None] {
        return Err(Nothing::Elsewhere);
    }
    let both = |values: &[f64]| {
        places.map(|place| {
            let value = place.and_then(|at| values.get(at));
            value.copied().unwrap_or(f64::NAN)
        })
    };
    let mut sample = Sample::stamped(&message.header);
    sample.angle = both(&message.position);
    sample.speed = both(&message.velocity);
    sample.torque = both(&message.effort);
    Ok(sample)
}

type TfMessage = ros::TfMessage<Vec<ros::TransformStamped<String>>>;

fn transform(pick: &Pick, data: &[u8]) -> Result<Sample, Nothing> {
    let message: TfMessage = decode(data)?;
    let wanted = |transform: &&ros::TransformStamped<String>| {
        pick.frame.as_ref() == Some(&transform.child_frame_id)
    };
    let transform = message.transforms.iter().find(wanted);
    let transform = transform.ok_or(Nothing::Elsewhere)?;
    let pose = Pose {
        position: transform.translation,
        orientation: transform.rotation,
    };
    Ok(Sample::stamped(&transform.header).with_pose(&pose))
}
