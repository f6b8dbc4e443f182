//! The changes of a trial of a watch.

use slipstream_bus::RobotModel;
use slipstream_recording::Recording;
use slipstream_trial::own::Change;

/// Sizes of changes, over the smallest that the rest of the recording would show.
pub(super) const MULTIPLES: [f64; 5] = [1.0, 2.0, 3.0, 5.0, 8.0];
/// Largest change of a wheel (as a logarithm), of a stamp (s), of a place over the half track, of a direction (rad).
const MOST: [f64; 4] = [0.3, 0.6, 2.0, 0.5];

/// A change that a size is put into.
pub(super) struct Kind {
    pub(super) effect: &'static str,
    pub(super) parameter: &'static str,
    pub(super) both: bool,
    pub(super) most: f64,
    pub(super) of: fn(f64) -> Change,
}

impl Kind {
    /// Whether its size is the logarithm of a factor.
    pub(super) fn is_factor(&self) -> bool {
        let [factor, ..] = MOST;
        self.most == factor
    }
}

/// The changes that can be put into a recording.
pub(super) fn all(heard: &Recording, model: &RobotModel) -> Vec<Kind> {
    let driven = heard
        .robots
        .first()
        .is_some_and(|own| own.command.is_some());
    let b = model.robot.half_track_m;
    let [factor, stamp_s, place, turned_rad] = MOST;
    let kind = |effect, parameter, both, most, of| Kind {
        effect,
        parameter,
        both,
        most,
        of,
    };
    let mut all = vec![
        kind(
            "pose_latency",
            "latency_s",
            false,
            stamp_s,
            Change::PoseLate as fn(f64) -> Change,
        ),
        kind("imu_latency", "latency_s", false, stamp_s, Change::GyroLate),
        kind(
            "wheels_latency",
            "latency_s",
            false,
            stamp_s,
            Change::WheelsLate,
        ),
        kind(
            "actuator_delay",
            "delay_s",
            false,
            stamp_s,
            Change::CommandLate,
        ),
        kind("pose_offset", "x_m", false, place * b, |x| {
            Change::Offset([x, 0.0])
        }),
        kind("pose_offset", "y_m", false, place * b, |y| {
            Change::Offset([0.0, y])
        }),
        kind("pose_offset", "yaw_rad", false, turned_rad, Change::Turned),
        kind("motor_gain", "right", true, factor, |x| {
            Change::Gain(x.exp())
        }),
        kind("encoder_scale", "right_scale", true, factor, |x| {
            Change::Counts([x.exp(); 2])
        }),
        kind("encoder_scale", "left_scale", false, factor, |x| {
            Change::Counts([1.0, x.exp()])
        }),
    ];
    if !driven {
        all.push(kind("wheel_radius", "right_scale", true, factor, |x| {
            Change::Radius([x.exp(); 2])
        }));
        all.push(kind("wheel_radius", "right_scale", false, factor, |x| {
            Change::Radius([x.exp(), 1.0])
        }));
        all.push(kind("wheel_radius", "left_scale", false, factor, |x| {
            Change::Radius([1.0, x.exp()])
        }));
    }
    all
}
