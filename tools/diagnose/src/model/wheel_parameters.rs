//! Parameters of a machine that is seen from its wheels: their places in the vector that the search fits, and what each
//! filter reads of those of one run.

use slipstream_sim::Scalar;

use super::drive::DRIVE;
use crate::filter::motion_law::{LAW, OF_TURNS};
use crate::filter::wheels_to_pose;

/// Parameters of the machine.
pub(crate) const COMMON: usize = 0;
pub(crate) const ASYMMETRY: usize = 1;
pub(crate) const TRACK: usize = 2;
pub(crate) const OFFSET_X: usize = 3;
pub(crate) const OFFSET_Y: usize = 4;
pub(crate) const OFFSET_YAW: usize = 5;
pub(crate) const POSE_LATENCY: usize = 6;
pub(crate) const POSE_RATE: usize = 7;
pub(crate) const GYRO_LATENCY: usize = 8;
pub(crate) const GYRO_RATE: usize = 9;
/// Parameters of the drive begin here; they matter where no wheels were recorded.
pub(crate) const DRIVE_FIRST: usize = 10;
/// Values of laws of speed (m/s) and of turn rate (rad/s).
pub(crate) const LAW_FIRST: usize = DRIVE_FIRST + DRIVE;
/// Values of the law of turns, which poses and gyro see.
pub(crate) const TURNS_FIRST: usize = LAW_FIRST + OF_TURNS;
/// How many there are.
pub(crate) const MACHINE: usize = LAW_FIRST + LAW;
/// Parameters of each run, after those of the machine: scale, track, gyro bias, then noise sizes.
pub(crate) const RUN_SCALE: usize = 0;
pub(crate) const RUN_TRACK: usize = 1;
pub(crate) const RUN_BIAS: usize = 2;
/// How much later (s) and faster the gyro's clock is in this run than in all.
pub(crate) const RUN_LATE: usize = 3;
pub(crate) const RUN_RATE: usize = 4;
/// How much later (s) poses are stamped in this run than in all.
pub(crate) const RUN_POSE_LATE: usize = 5;
/// Noise sizes begin here.
pub(crate) const RUN_NOISE_FIRST: usize = 6;
pub(super) const RUN: usize = RUN_NOISE_FIRST;
/// Those that a run shares with the one from before on its course.
pub(super) const RUN_SHARED: [usize; 4] = [RUN_SCALE, RUN_TRACK, RUN_LATE, RUN_RATE];

/// Those of the drive, of the parameters that one run reads.
pub(crate) fn drive_parameters<S>(local: &[S]) -> &[S] {
    &local[DRIVE_FIRST..LAW_FIRST]
}

/// Those of the filter of poses.
pub(crate) fn pose_parameters<S: Scalar>(local: &[S]) -> Vec<S> {
    let run = &local[MACHINE..];
    let scale = local[COMMON] + run[RUN_SCALE];
    let half = local[ASYMMETRY] * 0.5;
    let mut all = vec![scale + half, scale - half, local[TRACK] + run[RUN_TRACK]];
    all.extend(&local[OFFSET_X..POSE_LATENCY]);
    all.extend([local[POSE_LATENCY] + run[RUN_POSE_LATE], local[POSE_RATE]]);
    all.extend(&local[LAW_FIRST..MACHINE]);
    all.extend(&run[RUN..RUN + wheels_to_pose::NOISE]);
    all
}

/// Those of the filter of the gyro.
pub(crate) fn gyro_parameters<S: Scalar>(local: &[S]) -> Vec<S> {
    let run = &local[MACHINE..];
    let scale = local[COMMON] + run[RUN_SCALE];
    let half = local[ASYMMETRY] * 0.5;
    let mut all = vec![scale + half, scale - half, local[TRACK] + run[RUN_TRACK]];
    all.extend([
        local[GYRO_LATENCY] + run[RUN_LATE],
        local[GYRO_RATE] + run[RUN_RATE],
        run[RUN_BIAS],
    ]);
    all.extend(&local[TURNS_FIRST..MACHINE]);
    all.extend(&run[RUN + wheels_to_pose::NOISE..]);
    all
}
