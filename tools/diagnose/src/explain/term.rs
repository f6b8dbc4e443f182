//! One term of a calibration or a drive: its name, and what it is made of.

use crate::select::elimination::Term;

/// The rate of a clock wanders more slowly than blocks see, and than its latency.
pub(super) const RATE_CAUTION: f64 = 1.75;
/// What the rate of a clock has to gain before anything may lean on it (nats).
pub(super) const RATE_NATS: f64 = 6.0;
/// What lasts has to lower the error of predictions by this share.
pub(super) const USE_SHARE: f64 = 0.02;
/// Radii and track are one calibration: they are estimated, kept and removed together.
pub(crate) const GEOMETRY: &str = "geometry";
/// Scale and track of single runs, beside recordings from before: what floor and load changed.
pub(crate) const FLOOR: &str = "floor";
pub(crate) const LAW_TERMS: [&str; 2] = ["law of w", "law of v"];
pub(crate) const OFFSET: &str = "offset";
pub(crate) const OFFSET_TURN: &str = "offset yaw";
pub(crate) const POSE_LATE: &str = "pose latency";
pub(crate) const POSE_CLOCK: &str = "pose rate";
pub(crate) const GYRO_LATE: &str = "gyro latency";
pub(crate) const GYRO_CLOCK: &str = "gyro rate";
/// Names of the terms of a drive.
pub(crate) const DELAY_TERM: &str = "delay";
pub(crate) const LAG_TERM: &str = "lag";
pub(crate) const GAIN_TERM: &str = "gain";
pub(crate) const BAND_TERM: &str = "dead band";
pub(crate) const ZONE_TERM: &str = "dead zone";
pub(crate) const SATURATION_TERM: &str = "saturation";
pub(crate) const SAG_TERM: &str = "sag";
pub(crate) const CLOCK_TERM: &str = "wheel clock";
pub(super) const SLOW_TERM: &str = "slow response";

/// A term of these parameters, each with the size below which nobody would call it a difference.
pub(super) fn term(name: &'static str, parameters: &[(usize, f64)], caution: f64) -> Term {
    Term {
        name,
        parameters: parameters.iter().map(|(index, _)| *index).collect(),
        floors: parameters.iter().map(|(_, floor)| floor * floor).collect(),
        unnoticed: vec![0.0; parameters.len()],
        caution,
        by_profile: false,
        positive: false,
        lasting: false,
    }
}
