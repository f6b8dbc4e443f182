//! Fields of the ROS messages, in the order of [`definitions`](super::definitions).
//!
//! Texts (`S`) and lists (`L`, `N`, `V`, `T`, `B`) are type parameters: borrowed when a message is
//! written, owned when it is read.

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Time {
    pub(crate) sec: i32,
    pub(crate) nanosec: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Header<S> {
    pub(crate) stamp: Time,
    pub(crate) frame_id: S,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Vector3 {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Quaternion {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
    pub(crate) w: f64,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Pose {
    pub(crate) position: Vector3,
    pub(crate) orientation: Quaternion,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Twist {
    pub(crate) linear: Vector3,
    pub(crate) angular: Vector3,
}

/// Covariance of six coordinates, row by row; ROS stores it as 36 numbers.
pub(crate) type Covariance6 = [[f64; 6]; 6];

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct PoseStamped<S> {
    pub(crate) header: Header<S>,
    pub(crate) pose: Pose,
}

#[derive(Debug, Deserialize)]
pub(crate) struct PointStamped<S> {
    pub(crate) header: Header<S>,
    pub(crate) point: Vector3,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct PoseWithCovarianceStamped<S> {
    pub(crate) header: Header<S>,
    pub(crate) pose: Pose,
    pub(crate) covariance: Covariance6,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TwistStamped<S> {
    pub(crate) header: Header<S>,
    pub(crate) twist: Twist,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Odometry<S> {
    pub(crate) header: Header<S>,
    pub(crate) child_frame_id: S,
    pub(crate) pose: Pose,
    pub(crate) pose_covariance: Covariance6,
    pub(crate) twist: Twist,
    pub(crate) twist_covariance: Covariance6,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct JointState<S, N, V> {
    pub(crate) header: Header<S>,
    pub(crate) name: N,
    pub(crate) position: V,
    pub(crate) velocity: V,
    pub(crate) effort: V,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Imu<S> {
    pub(crate) header: Header<S>,
    pub(crate) orientation: Quaternion,
    pub(crate) orientation_covariance: [f64; 9],
    pub(crate) angular_velocity: Vector3,
    pub(crate) angular_velocity_covariance: [f64; 9],
    pub(crate) linear_acceleration: Vector3,
    pub(crate) linear_acceleration_covariance: [f64; 9],
}

/// Numbers in the order that sender and receiver have agreed on.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Float64MultiArray<D, V> {
    pub(crate) layout: MultiArrayLayout<D>,
    pub(crate) data: V,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MultiArrayLayout<D> {
    pub(crate) dim: D,
    pub(crate) data_offset: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MultiArrayDimension<S> {
    pub(crate) label: S,
    pub(crate) size: u32,
    pub(crate) stride: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TransformStamped<S> {
    pub(crate) header: Header<S>,
    pub(crate) child_frame_id: S,
    pub(crate) translation: Vector3,
    pub(crate) rotation: Quaternion,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TfMessage<L> {
    pub(crate) transforms: L,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct EncoderTicks<S> {
    pub(crate) header: Header<S>,
    pub(crate) right: i64,
    pub(crate) left: i64,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct WheelVoltage<S> {
    pub(crate) header: Header<S>,
    pub(crate) right_v: f64,
    pub(crate) left_v: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MotorState<S> {
    pub(crate) header: Header<S>,
    pub(crate) current_right_a: f64,
    pub(crate) current_left_a: f64,
    pub(crate) supply_v: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct PositionMessage<S> {
    pub(crate) header: Header<S>,
    pub(crate) sender: S,
    pub(crate) receiver: S,
    pub(crate) seq: u64,
    pub(crate) t_sampled_ns: i64,
    pub(crate) t_sent_ns: i64,
    pub(crate) t_received_ns: i64,
    pub(crate) fate: u8,
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    pub(crate) yaw_rad: f64,
    pub(crate) v_m_s: f64,
    pub(crate) w_rad_s: f64,
}

/// A position message as it is written. Recordings of before have no extra numbers, so it is read without.
#[derive(Debug, Serialize)]
pub(crate) struct WrittenPosition<'a> {
    pub(crate) position: PositionMessage<&'a str>,
    pub(crate) extra: &'a [f64],
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct WheelContact {
    pub(crate) state: u8,
    pub(crate) slip_longitudinal_m_s: f64,
    pub(crate) slip_lateral_m_s: f64,
    pub(crate) normal_force_n: f64,
    pub(crate) applied_torque_nm: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Contact<S> {
    pub(crate) header: Header<S>,
    pub(crate) right: WheelContact,
    pub(crate) left: WheelContact,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct TraceEvent<B> {
    pub(crate) stamp: Time,
    pub(crate) postcard: B,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Event<S> {
    pub(crate) stamp: Time,
    pub(crate) process: S,
    pub(crate) text: S,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct RoundTrip {
    pub(crate) seq: i64,
    pub(crate) rtt_ms: f64,
}

/// One row of a stream without loss: numbers (NaN if empty), and as text everything else (counts,
/// names, columns that the format does not define).
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Row<V, T> {
    pub(crate) t_s: f64,
    pub(crate) numbers: V,
    pub(crate) texts: T,
}

impl Time {
    /// Nanoseconds split into seconds and nanoseconds. Seconds beyond 32 bits are clamped.
    pub(crate) fn from_ns(t_ns: i64) -> Self {
        let sec = t_ns.div_euclid(1_000_000_000);
        Self {
            sec: sec.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32,
            nanosec: t_ns.rem_euclid(1_000_000_000) as u32,
        }
    }

    /// The time in nanoseconds.
    pub(crate) fn ns(self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }
}

impl Vector3 {
    pub(crate) const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }
}

impl Quaternion {
    /// Rotation by `yaw_rad` about the vertical.
    pub(crate) fn from_yaw(yaw_rad: f64) -> Self {
        let (z, w) = (yaw_rad / 2.0).sin_cos();
        Self {
            x: 0.0,
            y: 0.0,
            z,
            w,
        }
    }

    /// Heading (rad) of any rotation, in [-π, π].
    pub(crate) fn yaw(self) -> f64 {
        let Self { x, y, z, w } = self;
        (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
    }
}

impl Pose {
    /// Pose in the plane.
    pub(crate) fn planar(x_m: f64, y_m: f64, yaw_rad: f64) -> Self {
        Self {
            position: Vector3::new(x_m, y_m, 0.0),
            orientation: Quaternion::from_yaw(yaw_rad),
        }
    }
}

impl Twist {
    /// Velocity in the plane: forward (m/s), to the left (m/s), counter-clockwise (rad/s).
    pub(crate) fn planar(forward_m_s: f64, left_m_s: f64, yaw_rate_rad_s: f64) -> Self {
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
