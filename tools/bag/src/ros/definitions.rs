//! Message definitions (`.msg` text), embedded in every file so that any reader can decode it.

use std::fmt::Write as _;

/// A message type that slipstream writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the name of the type says what it is")]
pub enum MessageType {
    JointState,
    PoseStamped,
    TwistStamped,
    Odometry,
    Imu,
    TfMessage,
    EncoderTicks,
    WheelVoltage,
    MotorState,
    PositionMessage,
    Contact,
    TraceEvent,
    Event,
    RoundTrip,
    Row,
}

impl MessageType {
    /// Name of the type in ROS 2.
    pub fn name(self) -> &'static str {
        match self {
            Self::JointState => "sensor_msgs/msg/JointState",
            Self::PoseStamped => "geometry_msgs/msg/PoseStamped",
            Self::TwistStamped => "geometry_msgs/msg/TwistStamped",
            Self::Odometry => "nav_msgs/msg/Odometry",
            Self::Imu => "sensor_msgs/msg/Imu",
            Self::TfMessage => "tf2_msgs/msg/TFMessage",
            Self::EncoderTicks => "slipstream_msgs/msg/EncoderTicks",
            Self::WheelVoltage => "slipstream_msgs/msg/WheelVoltage",
            Self::MotorState => "slipstream_msgs/msg/MotorState",
            Self::PositionMessage => "slipstream_msgs/msg/PositionMessage",
            Self::Contact => "slipstream_msgs/msg/Contact",
            Self::TraceEvent => "slipstream_msgs/msg/TraceEvent",
            Self::Event => "slipstream_msgs/msg/Event",
            Self::RoundTrip => "slipstream_msgs/msg/RoundTrip",
            Self::Row => "slipstream_msgs/msg/Row",
        }
    }

    /// The definition of this type and of all types that it contains, in the `ros2msg` encoding.
    pub fn schema(self) -> String {
        let mut seen = vec![self.name().replace("/msg/", "/")];
        let mut text = String::new();
        let mut next = 0;
        while let Some(name) = seen.get(next).cloned() {
            let definition = definition(&name);
            if next > 0 {
                // Writing to a string cannot fail.
                let _ = write!(text, "{}\nMSG: {name}\n", "=".repeat(80));
            }
            text.push_str(definition);
            for inner in definition.lines().filter_map(type_of_field) {
                if inner.contains('/') && !seen.iter().any(|name| name == inner) {
                    seen.push(inner.to_owned());
                }
            }
            next += 1;
        }
        text
    }
}

/// Type of the field that a line of a definition declares, without array brackets.
fn type_of_field(line: &str) -> Option<&str> {
    let name = line.split_whitespace().next()?;
    let name = name.split('[').next()?;
    (!name.starts_with('#')).then_some(name)
}

/// Fields of each type. The standard types are those of ROS 2, without comments.
fn definition(name: &str) -> &'static str {
    match name {
        "builtin_interfaces/Time" => "int32 sec\nuint32 nanosec\n",
        "std_msgs/Header" => "builtin_interfaces/Time stamp\nstring frame_id\n",
        "geometry_msgs/Point" | "geometry_msgs/Vector3" => "float64 x\nfloat64 y\nfloat64 z\n",
        "geometry_msgs/Quaternion" => "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        "geometry_msgs/Pose" => {
            "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
        }
        "geometry_msgs/Twist" => "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n",
        "geometry_msgs/PoseWithCovariance" => "geometry_msgs/Pose pose\nfloat64[36] covariance\n",
        "geometry_msgs/TwistWithCovariance" => {
            "geometry_msgs/Twist twist\nfloat64[36] covariance\n"
        }
        "geometry_msgs/Transform" => {
            "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"
        }
        "geometry_msgs/TransformStamped" => {
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"
        }
        "geometry_msgs/PoseStamped" => "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
        "geometry_msgs/TwistStamped" => "std_msgs/Header header\ngeometry_msgs/Twist twist\n",
        "sensor_msgs/JointState" => {
            "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n\
             float64[] effort\n"
        }
        "sensor_msgs/Imu" => {
            "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n\
             float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n\
             float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n\
             float64[9] linear_acceleration_covariance\n"
        }
        "nav_msgs/Odometry" => {
            "std_msgs/Header header\nstring child_frame_id\n\
             geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n"
        }
        "tf2_msgs/TFMessage" => "geometry_msgs/TransformStamped[] transforms\n",
        other => slipstream_definition(other),
    }
}

/// Fields of the types that slipstream defines, with comments.
fn slipstream_definition(name: &str) -> &'static str {
    match name {
        "slipstream_msgs/EncoderTicks" => {
            "# Signed cumulative encoder counts.\nstd_msgs/Header header\nint64 right\nint64 left\n"
        }
        "slipstream_msgs/WheelVoltage" => {
            "# Voltage that each motor was told (V).\nstd_msgs/Header header\nfloat64 right_v\n\
             float64 left_v\n"
        }
        "slipstream_msgs/MotorState" => {
            "# Measured currents (A) and supply (V); NaN where not measured.\n\
             std_msgs/Header header\nfloat64 current_right_a\nfloat64 current_left_a\n\
             float64 supply_v\n"
        }
        "slipstream_msgs/PositionMessage" => {
            "# A position that one robot sent to another; known by sender and seq.\n\
             # header.stamp is the time of sending. Times in nanoseconds since the run began.\n\
             uint8 ARRIVED=0\nuint8 LOST=1\nuint8 IN_FLIGHT=2\nstd_msgs/Header header\n\
             string sender\nstring receiver\nuint64 seq\n\
             int64 t_sampled_ns # of the encoders behind the position\nint64 t_sent_ns\n\
             int64 t_received_ns # 0 unless it arrived\nuint8 fate\nfloat64 x_m\nfloat64 y_m\n\
             float64 yaw_rad\nfloat64 v_m_s # NaN where not sent\n\
             float64 w_rad_s # NaN where not sent\n\
             float64[] extra # of the sender's controller\n"
        }
        "slipstream_msgs/WheelContact" => {
            "# What one driven wheel does on the floor.\nuint8 STICKS=0\nuint8 SLIPS=1\n\
             uint8 state\nfloat64 slip_longitudinal_m_s # of the contact over the floor\n\
             float64 slip_lateral_m_s\nfloat64 normal_force_n\n\
             float64 applied_torque_nm # at the wheel\n"
        }
        "slipstream_msgs/Contact" => {
            "# True state of both contacts.\nstd_msgs/Header header\n\
             slipstream_msgs/WheelContact right\nslipstream_msgs/WheelContact left\n"
        }
        "slipstream_msgs/TraceEvent" => {
            "# A record of the trace, encoded with postcard (see slipstream trace).\n\
             builtin_interfaces/Time stamp\nuint8[] postcard\n"
        }
        "slipstream_msgs/Event" => {
            "# Something that happened, in words.\nbuiltin_interfaces/Time stamp\n\
             string process\nstring text\n"
        }
        "slipstream_msgs/RoundTrip" => {
            "# A measured network round trip.\nint64 seq\nfloat64 rtt_ms # NaN where not measured\n"
        }
        _ => {
            "# A row exactly as it was given; the channel's metadata names its columns.\n\
             float64 t_s\nfloat64[] numbers # NaN where the cell is empty\n\
             string[] texts # counts, names, columns that the format does not know\n"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schema_contains_every_nested_type_once() {
        let schema = MessageType::Odometry.schema();
        for name in ["geometry_msgs/Vector3", "builtin_interfaces/Time"] {
            let head = format!("MSG: {name}\n");
            assert_eq!(schema.matches(&head).count(), 1, "{schema}");
        }
        assert!(schema.starts_with("std_msgs/Header header\n"));
    }
}
