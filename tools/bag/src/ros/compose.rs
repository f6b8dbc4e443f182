//! ROS 2 messages composed from plain numbers, shared by recorded runs and imported recordings.

use super::messages::{self as ros, Header, Pose, Quaternion, Time, Twist, Vector3};

/// Name of the frame in which poses are given.
pub const WORLD: &str = "world";

/// Header with this time stamp (ns).
pub fn header(t_ns: i64, frame_id: &str) -> Header<&str> {
    Header {
        stamp: Time::from_ns(t_ns),
        frame_id,
    }
}

/// Names of the wheel joints, [right, left].
pub const JOINTS: [&str; 2] = ["wheel_right", "wheel_left"];

/// Joint state of both wheels: angles (rad), speeds (rad/s), torques (N m). A list may be empty.
pub fn joint_state<'a>(
    t_ns: i64,
    position: &'a [f64],
    velocity: &'a [f64],
    effort: &'a [f64],
) -> ros::JointState<&'a str, &'a [&'a str], &'a [f64]> {
    ros::JointState {
        header: header(t_ns, ""),
        name: &JOINTS,
        position,
        velocity,
        effort,
    }
}

/// IMU message. A covariance of -1 marks the orientation as not measured (ROS convention).
pub fn imu(t_ns: i64, [ax_m_s2, ay_m_s2, gz_rad_s]: [f64; 3]) -> ros::Imu<&'static str> {
    let mut not_measured = [0.0; 9];
    not_measured[0] = -1.0;
    ros::Imu {
        header: header(t_ns, ""),
        orientation: Quaternion::from_yaw(0.0),
        orientation_covariance: not_measured,
        angular_velocity: Vector3::new(0.0, 0.0, gz_rad_s),
        angular_velocity_covariance: [0.0; 9],
        linear_acceleration: Vector3::new(ax_m_s2, ay_m_s2, 0.0),
        linear_acceleration_covariance: [0.0; 9],
    }
}

/// A robot's pose in the world, and its velocity in the body frame.
pub fn odometry(
    t_ns: i64,
    robot: &str,
    [x_m, y_m, yaw_rad]: [f64; 3],
    twist: Twist,
) -> ros::Odometry<&str> {
    ros::Odometry {
        header: header(t_ns, WORLD),
        child_frame_id: robot,
        pose: Pose::planar(x_m, y_m, yaw_rad),
        pose_covariance: [[0.0; 6]; 6],
        twist,
        twist_covariance: [[0.0; 6]; 6],
    }
}
