//! The judge: what predictions over 5 s are worth, on blocks of time that no fit has seen, beside the error
//! that the sensors' noise and the reported process noise predict.
//!
//! It is given sums of errors, and knows nothing of how a model was found.

mod adequacy;
mod budget;
mod held_out;
mod score;
mod worse;

pub(crate) use adequacy::{Judged, conclude};
pub(crate) use budget::{Player, Squares, budget, culprits};
pub(crate) use held_out::held_out;
pub(crate) use score::{GYRO, HEADING, PLACE, POSE, QUANTITIES, Score};
pub(crate) use worse::worse;

/// Names of the quantities that are scored: the channels, then distance and heading.
pub(crate) const NAMES: [&str; QUANTITIES] = [
    "wheel_right",
    "wheel_left",
    "pose_x",
    "pose_y",
    "pose_yaw",
    "odometry_v",
    "odometry_w",
    "imu_ax",
    "imu_ay",
    "imu_gz",
    "position",
    "heading",
];
