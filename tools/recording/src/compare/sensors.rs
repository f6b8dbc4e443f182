//! Sensors.

use std::f64::consts::TAU;

use slipstream_bus::RobotModel;

use crate::recording::{PosePoint, Robot, Wheels};

/// Wheel angles (rad), [right, left], where they can be had.
pub(super) fn wheel_angles(robot: &Robot, model: &RobotModel) -> Option<[Vec<f64>; 2]> {
    match &robot.wheels.as_ref()?.values {
        Wheels::Angle {
            right_rad,
            left_rad,
        } => Some([right_rad.clone(), left_rad.clone()]),
        Wheels::Ticks { right, left } => {
            let of_model = model.encoder.as_ref().map(|encoder| encoder.counts_per_rev);
            let counts = robot.encoder_counts_per_rev.or(of_model)?;
            let rad_per_count = TAU / f64::from(counts);
            let angle = |count: &Option<i64>| count.map_or(f64::NAN, |c| c as f64 * rad_per_count);
            Some([right, left].map(|counts| counts.iter().map(angle).collect()))
        }
        Wheels::Speed { .. } => None,
    }
}

/// Distance from the tracked point forward to c (m).
pub(super) fn tracked_to_com_m(robot: &Robot, model: &RobotModel) -> f64 {
    match robot.pose_point {
        Some(PosePoint::Axle) => model.robot.com_to_axle_m.unwrap_or(0.0),
        _ => 0.0,
    }
}
