//! What was measured, in the form that filters read: wheel angles over time, reference poses and the
//! integrated gyro as thinned series.
//!
//! Rows of a real log are not independent: lags that follow a saw-tooth, held values, dropped frames.
//! At full rate their structure is taken for evidence. So rows half a second apart are filtered in
//! interleaved series whose log-likelihoods are averaged (composite likelihood; Varin, Reid and Firth
//! 2011).

pub(crate) mod command;
pub(crate) mod faults;
pub(crate) mod feed;
pub(crate) mod matched;
pub(crate) mod noise;
pub(crate) mod reference;
pub(crate) mod streams;
pub(crate) mod track;
pub(crate) mod wheel_path;
pub(crate) mod wheel_rows;
pub(crate) mod wheels;

use slipstream_recording::recording::Robot;

/// Stamps beyond this are those of a calendar or a boot: the clock's rate is then counted from the
/// first row.
const EPOCH_S: f64 = 1e5;

/// The instant (s) that counts as zero in the fit, given the first stamp of the recording.
fn origin(first_s: f64) -> f64 {
    if first_s.abs() > EPOCH_S {
        first_s
    } else {
        0.0
    }
}

/// The instant (s) that counts as zero in the recording of a robot.
pub(crate) fn origin_of(robot: &Robot) -> f64 {
    let firsts = robot.stamps().filter_map(|own| own.first().copied());
    origin(firsts.fold(f64::INFINITY, f64::min))
}
