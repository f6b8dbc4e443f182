//! Copies in which nothing changed but what nobody would call a change.

use slipstream_recording::Recording;
use slipstream_recording::recording::Robot;

use super::rows::{keep_measured, keep_told, span_s, times};

/// By how much another origin of time is later (s).
const ORIGIN_S: f64 = 4321.5;
/// Number and length (s) of gaps.
const GAPS: u32 = 3;
const GAP_S: f64 = 0.8;
/// Every so manyth pose is an outlier, by this much (m, rad).
const OUTLIER: usize = 97;
const OUTLIER_M: f64 = 0.7;
const OUTLIER_RAD: f64 = 0.5;

/// What was done to a copy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Null {
    /// Nothing.
    Itself,
    /// Some rows are missing.
    Gaps,
    /// Some poses are plainly wrong.
    Outliers,
    /// Times count from elsewhere.
    Origin,
}

impl Null {
    pub(super) const ALL: [Self; 4] = [Self::Itself, Self::Gaps, Self::Outliers, Self::Origin];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Itself => "itself",
            Self::Gaps => "gaps",
            Self::Outliers => "outliers",
            Self::Origin => "origin of time",
        }
    }

    pub(super) fn apply(self, robot: &mut Robot) {
        match self {
            Self::Itself => {}
            Self::Origin => times(robot).for_each(|t_s| *t_s += ORIGIN_S),
            Self::Outliers => {
                let Some(pose) = robot.pose.as_mut().map(|own| &mut own.values) else {
                    return;
                };
                for row in (OUTLIER / 2..pose.x_m.len()).step_by(OUTLIER) {
                    let sign = if row % 2 == 0 { 1.0 } else { -1.0 };
                    pose.x_m[row] += sign * OUTLIER_M;
                    if let Some(yaws) = &mut pose.yaw_rad {
                        yaws[row] += sign * OUTLIER_RAD;
                    }
                }
            }
            Self::Gaps => {
                let [from_s, to_s] = span_s(robot);
                let places = (1..=GAPS).map(|k| {
                    let share = f64::from(k) / f64::from(GAPS + 1);
                    from_s + share * (to_s - from_s)
                });
                let places: Vec<f64> = places.collect();
                keep_measured(robot, &|t_s| {
                    places.iter().all(|at| t_s < *at || t_s > at + GAP_S)
                });
            }
        }
    }
}

/// The first or the second half of a recording.
pub fn half(recording: &Recording, second: bool) -> Recording {
    let mut half = recording.clone();
    half.links = None;
    half.rtt = None;
    for robot in &mut half.robots {
        let [from_s, to_s] = span_s(robot);
        let middle_s = f64::midpoint(from_s, to_s);
        let [from_s, to_s] = if second {
            [middle_s, to_s]
        } else {
            [from_s, middle_s]
        };
        keep_measured(robot, &|t_s| t_s >= from_s && t_s <= to_s);
        keep_told(robot, [from_s, to_s]);
    }
    half.name = format!(
        "{}, {} half",
        recording.name,
        if second { "second" } else { "first" }
    );
    half
}
