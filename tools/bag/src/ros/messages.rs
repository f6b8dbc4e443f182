//! Fields of the ROS messages, in the order of their definitions.
//!
//! Texts (`S`) and lists (`L`, `N`, `V`, `T`, `B`) are type parameters: borrowed when a message is
//! written, owned when it is read.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    pub sec: i32,
    pub nanosec: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Header<S> {
    pub stamp: Time,
    pub frame_id: S,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Pose {
    pub position: Vector3,
    pub orientation: Quaternion,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Twist {
    pub linear: Vector3,
    pub angular: Vector3,
}

/// Covariance of six coordinates, row by row; ROS stores it as 36 numbers.
pub type Covariance6 = [[f64; 6]; 6];

#[derive(Debug, Serialize, Deserialize)]
pub struct PoseStamped<S> {
    pub header: Header<S>,
    pub pose: Pose,
}

#[derive(Debug, Deserialize)]
pub struct PointStamped<S> {
    pub header: Header<S>,
    pub point: Vector3,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped<S> {
    pub header: Header<S>,
    pub pose: Pose,
    pub covariance: Covariance6,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct TwistStamped<S> {
    pub header: Header<S>,
    pub twist: Twist,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Odometry<S> {
    pub header: Header<S>,
    pub child_frame_id: S,
    pub pose: Pose,
    pub pose_covariance: Covariance6,
    pub twist: Twist,
    pub twist_covariance: Covariance6,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct JointState<S, N, V> {
    pub header: Header<S>,
    pub name: N,
    pub position: V,
    pub velocity: V,
    pub effort: V,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Imu<S> {
    pub header: Header<S>,
    pub orientation: Quaternion,
    pub orientation_covariance: [f64; 9],
    pub angular_velocity: Vector3,
    pub angular_velocity_covariance: [f64; 9],
    pub linear_acceleration: Vector3,
    pub linear_acceleration_covariance: [f64; 9],
}

/// Numbers in the order that sender and receiver have agreed on.
#[derive(Debug, Serialize, Deserialize)]
pub struct Float64MultiArray<D, V> {
    pub layout: MultiArrayLayout<D>,
    pub data: V,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct MultiArrayLayout<D> {
    pub dim: D,
    pub data_offset: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct MultiArrayDimension<S> {
    pub label: S,
    pub size: u32,
    pub stride: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct TransformStamped<S> {
    pub header: Header<S>,
    pub child_frame_id: S,
    pub translation: Vector3,
    pub rotation: Quaternion,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct TfMessage<L> {
    pub transforms: L,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct EncoderTicks<S> {
    pub header: Header<S>,
    pub right: i64,
    pub left: i64,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct WheelVoltage<S> {
    pub header: Header<S>,
    pub right_v: f64,
    pub left_v: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct MotorState<S> {
    pub header: Header<S>,
    pub current_right_a: f64,
    pub current_left_a: f64,
    pub supply_v: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct PositionMessage<S> {
    pub header: Header<S>,
    pub sender: S,
    pub receiver: S,
    pub seq: u64,
    pub t_sampled_ns: i64,
    pub t_sent_ns: i64,
    pub t_received_ns: i64,
    pub fate: u8,
    pub x_m: f64,
    pub y_m: f64,
    pub yaw_rad: f64,
    pub v_m_s: f64,
    pub w_rad_s: f64,
}

/// A position message as it is written. Recordings of before have no extra numbers, so it is read without.
#[derive(Debug, Serialize)]
pub struct WrittenPosition<'a> {
    pub position: PositionMessage<&'a str>,
    pub extra: &'a [f64],
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct WheelContact {
    pub state: u8,
    pub slip_longitudinal_m_s: f64,
    pub slip_lateral_m_s: f64,
    pub normal_force_n: f64,
    pub applied_torque_nm: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Contact<S> {
    pub header: Header<S>,
    pub right: WheelContact,
    pub left: WheelContact,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct TraceEvent<B> {
    pub stamp: Time,
    pub postcard: B,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct Event<S> {
    pub stamp: Time,
    pub process: S,
    pub text: S,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RoundTrip {
    pub seq: i64,
    pub rtt_ms: f64,
}

/// One row of a stream without loss: numbers (NaN if empty), and as text everything else (counts,
/// names, columns that the format does not define).
#[derive(Debug, Serialize, Deserialize)]
pub struct Row<V, T> {
    pub t_s: f64,
    pub numbers: V,
    pub texts: T,
}

impl Time {
    /// Nanoseconds split into seconds and nanoseconds. Seconds beyond 32 bits are clamped.
    pub fn from_ns(t_ns: i64) -> Self {
        let sec = t_ns.div_euclid(1_000_000_000);
        Self {
            sec: sec.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32,
            nanosec: t_ns.rem_euclid(1_000_000_000) as u32,
        }
    }

    /// The time in nanoseconds.
    pub fn ns(self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }
}

impl Vector3 {
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }
}

impl Quaternion {
    /// Rotation by `yaw_rad` about the vertical.
    pub fn from_yaw(yaw_rad: f64) -> Self {
        let (z, w) = (yaw_rad / 2.0).sin_cos();
        Self {
            x: 0.0,
            y: 0.0,
            z,
            w,
        }
    }

    /// Heading (rad) of any rotation, in [-π, π].
    pub fn yaw(self) -> f64 {
        let Self { x, y, z, w } = self;
        (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
    }
}

impl Pose {
    /// Pose in the plane.
    pub fn planar(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        Self {
            position: Vector3::new(x_m, y_m, 0.0),
            orientation: Quaternion::from_yaw(yaw_rad),
        }
    }
}

impl Twist {
    /// Velocity in the plane: forward (m/s), to the left (m/s), counter-clockwise (rad/s).
    pub fn planar(forward_m_s: f64, left_m_s: f64, yaw_rate_rad_s: f64) -> Self {
        Self {
            linear: Vector3::new(forward_m_s, left_m_s, 0.0),
            angular: Vector3::new(0.0, 0.0, yaw_rate_rad_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_times_round_trip() {
        for t_ns in [0, 1, -1, 1_999_999_999, -2_000_000_001] {
            assert_eq!(Time::from_ns(t_ns).ns(), t_ns);
        }
    }

    #[test]
    fn yaw_round_trips_up_to_whole_turns() {
        for yaw in [0.0, 1.0, -3.1, 3.0 + std::f64::consts::TAU] {
            let back = Quaternion::from_yaw(yaw).yaw();
            assert!(((yaw - back) / std::f64::consts::TAU).fract().abs() < 1e-12);
            assert!(back.abs() <= std::f64::consts::PI);
        }
    }
}
