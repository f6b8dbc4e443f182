//! The predictions of one machine as they are answered.

use super::NAMES;
use super::score::{GYRO, PLACE, POSE, Score};
use crate::answer::{HeldOut, HeldOutChannel};

/// Channels that make up the total: the pose, or wheels and gyro where there is none.
const OF_POSE: [usize; 3] = [POSE, POSE + 1, POSE + 2];
const OF_OTHERS: [usize; 3] = [0, 1, GYRO];

/// Predictions of the windows of one machine before and after; `unit` is that of each channel.
pub(crate) fn held_out(
    robot: &str,
    horizon_s: f64,
    [before, after]: [&Score; 2],
    unit: &dyn Fn(usize) -> &'static str,
) -> HeldOut {
    let channels = (0..PLACE).filter_map(|channel| {
        let root = |score: &Score| score.mean_square(channel).map(f64::sqrt);
        Some(HeldOutChannel {
            robot: robot.to_owned(),
            channel: NAMES[channel].to_owned(),
            nrmse_before: before.level(&[channel])?,
            nrmse_after: after.level(&[channel])?,
            unit: unit(channel),
            rms_before: root(before)?,
            rms_after: root(after)?,
            rms_expected: after.expected(channel)?.sqrt(),
        })
    });
    let total: &[usize] = if OF_POSE.iter().any(|channel| before.has(*channel)) {
        &OF_POSE
    } else {
        &OF_OTHERS
    };
    HeldOut {
        channels: channels.collect(),
        nrmse_before: before.level(total).unwrap_or(0.0),
        nrmse_after: after.level(total).unwrap_or(0.0),
        horizon_s,
    }
}
