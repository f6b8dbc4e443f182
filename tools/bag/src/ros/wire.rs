//! Messages of robots as they go over a network: ROS 2 messages in CDR, to and from plain numbers.
//!
//! Times are stamps of the header (ns); pairs are [right, left]; poses are x (m), y (m), yaw (rad); twists are v (m/s)
//! and w (rad/s). What cannot be read is an error in words: the bytes come from a stranger.

use super::cdr::{decode, encode};
use super::compose;
use super::messages::{self as ros, Header, Pose, Quaternion, Twist};

/// What a message says, with the time of its header (ns).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stamped<T> {
    /// Stamp of the header (ns); 0 where nobody set it.
    pub stamp_ns: i64,
    /// The content.
    pub value: T,
}

/// Pose and velocity of an odometry message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryValue {
    /// x (m), y (m), yaw (rad).
    pub pose: [f64; 3],
    /// v (m/s), w (rad/s).
    pub velocity: [f64; 2],
}

/// What an inertial sensor measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuValue {
    /// Specific force forward and to the left (m/s²).
    pub acceleration_m_s2: [f64; 2],
    /// Yaw rate (rad/s).
    pub yaw_rate_rad_s: f64,
}

/// Reads `sensor_msgs/msg/JointState`: the angles of two joints (rad), by their names.
///
/// # Errors
/// The bytes are no such message, or it lacks a joint or its angle.
pub fn read_joint_angles(bytes: &[u8], joints: [&str; 2]) -> Result<Stamped<[f64; 2]>, String> {
    let message: ros::JointState<String, Vec<String>, Vec<f64>> = decode(bytes)?;
    let mut angles = [0.0; 2];
    for (angle, joint) in angles.iter_mut().zip(joints) {
        let place = message.name.iter().position(|name| name == joint);
        let Some(place) = place else {
            let known = message.name.join(", ");
            return Err(format!("has no joint {joint} (it has {known})"));
        };
        let found = message.position.get(place).filter(|own| own.is_finite());
        *angle = *found.ok_or_else(|| format!("has no angle of joint {joint}"))?;
    }
    Ok(stamped(&message.header, angles))
}

/// Reads `nav_msgs/msg/Odometry`.
///
/// # Errors
/// The bytes are no such message, or its numbers are none.
pub fn read_odometry(bytes: &[u8]) -> Result<Stamped<OdometryValue>, String> {
    let message: ros::Odometry<String> = decode(bytes)?;
    let pose = planar(&message.pose)?;
    let velocity = finite([message.twist.linear.x, message.twist.angular.z])?;
    Ok(stamped(&message.header, OdometryValue { pose, velocity }))
}

/// Reads `geometry_msgs/msg/PoseStamped`.
///
/// # Errors
/// As [`read_odometry`].
pub fn read_pose(bytes: &[u8]) -> Result<Stamped<[f64; 3]>, String> {
    let message: ros::PoseStamped<String> = decode(bytes)?;
    Ok(stamped(&message.header, planar(&message.pose)?))
}

/// Reads `geometry_msgs/msg/Twist`.
///
/// # Errors
/// As [`read_odometry`].
pub fn read_twist(bytes: &[u8]) -> Result<[f64; 2], String> {
    let message: Twist = decode(bytes)?;
    finite([message.linear.x, message.angular.z])
}

/// Reads `geometry_msgs/msg/TwistStamped`.
///
/// # Errors
/// As [`read_odometry`].
pub fn read_twist_stamped(bytes: &[u8]) -> Result<Stamped<[f64; 2]>, String> {
    let message: ros::TwistStamped<String> = decode(bytes)?;
    let twist = finite([message.twist.linear.x, message.twist.angular.z])?;
    Ok(stamped(&message.header, twist))
}

/// Reads `sensor_msgs/msg/Imu`.
///
/// # Errors
/// As [`read_odometry`].
pub fn read_imu(bytes: &[u8]) -> Result<Stamped<ImuValue>, String> {
    let message: ros::Imu<String> = decode(bytes)?;
    let force = message.linear_acceleration;
    let [ax, ay, yaw_rate_rad_s] = finite([force.x, force.y, message.angular_velocity.z])?;
    let acceleration_m_s2 = [ax, ay];
    let value = ImuValue {
        acceleration_m_s2,
        yaw_rate_rad_s,
    };
    Ok(stamped(&message.header, value))
}

/// Reads `std_msgs/msg/Float64MultiArray` of two numbers, such as the efforts of two joints.
///
/// # Errors
/// As [`read_odometry`], or it has not two numbers.
pub fn read_two_numbers(bytes: &[u8]) -> Result<[f64; 2], String> {
    let message: ros::Float64MultiArray<Vec<ros::MultiArrayDimension<String>>, Vec<f64>> =
        decode(bytes)?;
    let numbers = <[f64; 2]>::try_from(message.data);
    finite(numbers.map_err(|all| format!("has {} numbers in place of two", all.len()))?)
}

/// `geometry_msgs/msg/Twist`.
pub fn twist([v_m_s, w_rad_s]: [f64; 2]) -> Vec<u8> {
    encoded(&Twist::planar(v_m_s, 0.0, w_rad_s))
}

/// `geometry_msgs/msg/TwistStamped`, stamped at `t_ns`.
pub fn twist_stamped(t_ns: i64, [v_m_s, w_rad_s]: [f64; 2]) -> Vec<u8> {
    encoded(&ros::TwistStamped {
        header: compose::header(t_ns, "base_link"),
        twist: Twist::planar(v_m_s, 0.0, w_rad_s),
    })
}

/// `sensor_msgs/msg/JointState` of two joints: angles (rad).
pub fn joint_angles(t_ns: i64, joints: [&str; 2], angle_rad: [f64; 2]) -> Vec<u8> {
    encoded(&ros::JointState {
        header: compose::header(t_ns, ""),
        name: &joints[..],
        position: &angle_rad[..],
        velocity: &[][..],
        effort: &[][..],
    })
}

/// `nav_msgs/msg/Odometry` of a robot whose frame is `frame`.
pub fn odometry(
    t_ns: i64,
    frame: &str,
    OdometryValue { pose, velocity }: OdometryValue,
) -> Vec<u8> {
    let [v_m_s, w_rad_s] = velocity;
    let twist = Twist::planar(v_m_s, 0.0, w_rad_s);
    encoded(&compose::odometry(t_ns, frame, pose, twist))
}

/// `geometry_msgs/msg/PoseStamped`.
pub fn pose(t_ns: i64, [x_m, y_m, yaw_rad]: [f64; 3]) -> Vec<u8> {
    encoded(&ros::PoseStamped {
        header: compose::header(t_ns, compose::WORLD),
        pose: Pose::planar(x_m, y_m, yaw_rad),
    })
}

/// `sensor_msgs/msg/Imu`.
pub fn imu(t_ns: i64, value: ImuValue) -> Vec<u8> {
    let [ax, ay] = value.acceleration_m_s2;
    encoded(&compose::imu(t_ns, [ax, ay, value.yaw_rate_rad_s]))
}

/// `std_msgs/msg/Float64MultiArray` of two numbers.
pub fn two_numbers(numbers: [f64; 2]) -> Vec<u8> {
    let no_dimensions: &[ros::MultiArrayDimension<&str>] = &[];
    encoded(&ros::Float64MultiArray {
        layout: ros::MultiArrayLayout {
            dim: no_dimensions,
            data_offset: 0,
        },
        data: &numbers[..],
    })
}

fn stamped<T>(header: &Header<String>, value: T) -> Stamped<T> {
    let stamp_ns = header.stamp.ns();
    Stamped { stamp_ns, value }
}

/// Pose in the plane.
fn planar(pose: &Pose) -> Result<[f64; 3], String> {
    let Quaternion { x, y, z, w } = pose.orientation;
    if x == 0.0 && y == 0.0 && z == 0.0 && w == 0.0 {
        return Err("has an orientation of zeros".to_owned());
    }
    finite([pose.position.x, pose.position.y, pose.orientation.yaw()])
}

fn finite<const N: usize>(numbers: [f64; N]) -> Result<[f64; N], String> {
    match numbers.iter().all(|number| number.is_finite()) {
        true => Ok(numbers),
        false => Err("has a number that is none (NaN or infinite)".to_owned()),
    }
}

/// The bytes of a message of ours: CDR represents all of them.
fn encoded(message: &impl serde::Serialize) -> Vec<u8> {
    let mut bytes = Vec::new();
    match encode(message, &mut bytes) {
        Ok(()) => bytes,
        Err(_) => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_read_back() {
        let t_ns = 1_700_000_000_123_456_789;
        assert_eq!(read_twist(&twist([0.2, -1.5])), Ok([0.2, -1.5]));
        let back = read_twist_stamped(&twist_stamped(t_ns, [0.2, -1.5])).unwrap();
        assert_eq!((back.stamp_ns, back.value), (t_ns, [0.2, -1.5]));
        let joints = ["wheel_right_joint", "wheel_left_joint"];
        let bytes = joint_angles(t_ns, joints, [1.25, -3.5]);
        let back = read_joint_angles(&bytes, joints).unwrap();
        assert_eq!((back.stamp_ns, back.value), (t_ns, [1.25, -3.5]));
        let [right, left] = joints;
        assert_eq!(
            read_joint_angles(&bytes, [left, right]).unwrap().value,
            [-3.5, 1.25]
        );
        let told = OdometryValue {
            pose: [1.0, 2.0, 0.5],
            velocity: [0.3, 0.1],
        };
        let back = read_odometry(&odometry(t_ns, "base", told)).unwrap();
        assert_eq!(back.value.velocity, told.velocity);
        assert!((back.value.pose[2] - 0.5).abs() < 1e-12);
        assert_eq!(
            read_pose(&pose(5, [1.0, 2.0, 0.0])).unwrap().value,
            [1.0, 2.0, 0.0]
        );
    }

    #[test]
    fn efforts_and_imu_read_back() {
        let bytes = two_numbers([0.25, -0.5]);
        // Encapsulation, no dimensions, offset 0, two numbers; doubles are aligned to 8 bytes after the encapsulation.
        assert_eq!(bytes.len(), 4 + 4 + 4 + 4 + 4 + 16);
        assert_eq!(read_two_numbers(&bytes), Ok([0.25, -0.5]));
        assert!(read_two_numbers(&two_numbers([f64::INFINITY, 0.0])).is_err());
        for cut in 0..bytes.len() {
            assert!(read_two_numbers(&bytes[..cut]).is_err(), "{cut}");
        }
        let value = ImuValue {
            acceleration_m_s2: [0.1, -0.2],
            yaw_rate_rad_s: 0.7,
        };
        let back = read_imu(&imu(7, value)).unwrap();
        assert_eq!((back.stamp_ns, back.value), (7, value));
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        let bytes = joint_angles(0, ["a", "b"], [0.0; 2]);
        let problem = read_joint_angles(&bytes, ["a", "c"]).unwrap_err();
        assert_eq!(problem, "has no joint c (it has a, b)");
        assert!(
            read_joint_angles(&joint_angles(0, ["a", "b"], [f64::NAN; 2]), ["a", "b"]).is_err()
        );
        assert!(read_twist(&twist([f64::NAN, 0.0])).is_err());
        assert!(read_pose(&[0, 1, 0]).is_err());
        for cut in 0..bytes.len() {
            let _ = read_joint_angles(&bytes[..cut], ["a", "b"]);
            let _ = read_odometry(&bytes[..cut]);
        }
    }
}
