//! Names of topics on the network, and what `rmw_zenoh` adds to a message.

#[cfg(any(feature = "zenoh", test))]
use crate::lab::Wire;
use crate::lab::{CommandMessage, Content, LabRobot, WheelTopic};

/// A topic and the type of its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// The name, without the leading `/`.
    pub name: String,
    /// The type.
    pub message: MessageType,
}

/// The types of messages that robots send and take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MessageType {
    /// `geometry_msgs/msg/Twist`.
    Twist,
    /// `geometry_msgs/msg/TwistStamped`.
    TwistStamped,
    /// `sensor_msgs/msg/JointState`.
    JointState,
    /// `nav_msgs/msg/Odometry`.
    Odometry,
    /// `geometry_msgs/msg/PoseStamped`.
    PoseStamped,
    /// `sensor_msgs/msg/Imu`.
    Imu,
    /// `std_msgs/msg/Float64MultiArray`.
    Float64MultiArray,
}

impl MessageType {
    /// Package, name, and the hash of the definition (REP 2016), which is the same in all releases since Iron.
    #[cfg(any(feature = "zenoh", test))]
    fn parts(self) -> [&'static str; 3] {
        match self {
            Self::Twist => [
                "geometry_msgs",
                "Twist",
                "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
            ],
            Self::TwistStamped => [
                "geometry_msgs",
                "TwistStamped",
                "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
            ],
            Self::JointState => [
                "sensor_msgs",
                "JointState",
                "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
            ],
            Self::Odometry => [
                "nav_msgs",
                "Odometry",
                "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
            ],
            Self::Imu => [
                "sensor_msgs",
                "Imu",
                "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b",
            ],
            Self::Float64MultiArray => [
                "std_msgs",
                "Float64MultiArray",
                "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f",
            ],
            Self::PoseStamped => [
                "geometry_msgs",
                "PoseStamped",
                "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
            ],
        }
    }
}

impl Topic {
    /// What a robot is told.
    pub fn of_command(robot: &LabRobot) -> Self {
        Self {
            name: robot.command.topic.clone(),
            message: match robot.command.message {
                CommandMessage::Twist => MessageType::Twist,
                CommandMessage::TwistStamped => MessageType::TwistStamped,
                CommandMessage::Efforts { .. } => MessageType::Float64MultiArray,
            },
        }
    }

    /// What a robot tells, if it has a topic for it.
    pub fn of(content: Content, robot: &LabRobot) -> Option<Self> {
        let name = content.topic(robot)?.to_owned();
        let message = match (content, &robot.wheels) {
            (Content::Wheels, WheelTopic::Joints { .. }) => MessageType::JointState,
            (Content::Wheels, WheelTopic::Odometry { .. }) | (Content::Odometry, _) => {
                MessageType::Odometry
            }
            (Content::Pose, _) => MessageType::PoseStamped,
            (Content::Imu, _) => MessageType::Imu,
        };
        Some(Self { name, message })
    }
}

#[cfg(any(feature = "zenoh", test))]
impl Topic {
    /// The key under which it is published.
    pub(super) fn key(&self, wire: Wire) -> String {
        let name = &self.name;
        match wire {
            Wire::Ros2dds => name.clone(),
            Wire::RmwZenoh { domain } => {
                let [package, message, hash] = self.message.parts();
                format!("{domain}/{name}/{package}::msg::dds_::{message}_/RIHS01_{hash}")
            }
        }
    }

    /// The keys under which it is heard.
    pub(super) fn heard_key(&self, wire: Wire) -> String {
        match wire {
            Wire::Ros2dds => self.name.clone(),
            Wire::RmwZenoh { domain } => format!("{domain}/{}/*/*", self.name),
        }
    }
}

/// What `rmw_zenoh` attaches to a message: number and time (ns since 1970) of the message, and an identifier of the
/// publisher with its length.
#[cfg(any(feature = "zenoh", test))]
pub(super) fn attachment(number: i64, stamp_ns: i64, publisher: [u8; 16]) -> [u8; 33] {
    let mut bytes = [0; 33];
    bytes[..8].copy_from_slice(&number.to_le_bytes());
    bytes[8..16].copy_from_slice(&stamp_ns.to_le_bytes());
    bytes[16] = 16;
    bytes[17..].copy_from_slice(&publisher);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_those_of_the_bridge_and_of_rmw_zenoh() {
        let topic = Topic {
            name: "tb1/cmd_vel".to_owned(),
            message: MessageType::Twist,
        };
        assert_eq!(topic.key(Wire::Ros2dds), "tb1/cmd_vel");
        let key = topic.key(Wire::RmwZenoh { domain: 5 });
        assert!(key.starts_with("5/tb1/cmd_vel/geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16"));
        assert_eq!(key.split('/').count(), 5);
        let heard = topic.heard_key(Wire::RmwZenoh { domain: 5 });
        assert_eq!(heard, "5/tb1/cmd_vel/*/*");
    }

    #[test]
    fn an_attachment_is_two_numbers_and_an_identifier() {
        let bytes = attachment(1, -1, [7; 16]);
        assert_eq!(bytes[..8], [1, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[8..16], [0xff; 8]);
        assert_eq!((bytes[16], &bytes[17..]), (16, &[7; 16][..]));
    }
}
