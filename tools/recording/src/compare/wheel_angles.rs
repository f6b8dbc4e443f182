//! Wheel angles from recorded angles or encoder counts.

use std::f64::consts::TAU;

use slipstream_bus::RobotModel;

use crate::recording::{Robot, Wheels};

/// Wheel angles (rad), [right, left]; NaN for empty cells. `None` if the wheels were recorded as
/// speeds, or as counts with unknown counts per revolution.
pub(super) fn wheel_angles(robot: &Robot, model: &RobotModel) -> Option<[Vec<f64>; 2]> {
    match &robot.wheels.as_ref()?.values {
        Wheels::Angle {
            right_rad,
            left_rad,
        } => Some([right_rad.clone(), left_rad.clone()]),
        Wheels::Ticks { right, left } => {
            let rad_per_count = TAU / robot.counts_per_rev(Some(model))?;
            let angle = |count: &Option<i64>| count.map_or(f64::NAN, |c| c as f64 * rad_per_count);
            Some([right, left].map(|counts| counts.iter().map(angle).collect()))
        }
        Wheels::Speed { .. } => None,
    }
}
