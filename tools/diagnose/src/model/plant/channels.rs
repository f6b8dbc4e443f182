//! Channels of measurement, and the likelihood of whitened innovations with a level for each.

use crate::filter::dynamic::Sensor;

/// Right and left wheel; x, y and yaw of the pose; along, across and turn of the inertial sensor.
pub(crate) const CHANNELS: usize = 8;
/// What was not measured belongs to no channel.
pub(crate) const NO_CHANNEL: u8 = u8::MAX;

/// The first channel of a sensor.
pub(crate) fn first(sensor: Sensor) -> u8 {
    match sensor {
        Sensor::WheelAngle | Sensor::WheelSpeed => 0,
        Sensor::Pose => 2,
        Sensor::Imu => 5,
    }
}

/// Mean square of the innovations of each channel, and how many there are.
pub(crate) fn levels(whitened: &[f64], channels: &[u8]) -> [[f64; 2]; CHANNELS] {
    let mut sums = [[0.0; 2]; CHANNELS];
    for (e, channel) in whitened.iter().zip(channels) {
        if let Some([sum, count]) = sums.get_mut(usize::from(*channel)) {
            *sum += e * e;
            *count += 1.0;
        }
    }
    sums.map(|[sum, count]| [if count > 0.0 { sum / count } else { 0.0 }, count])
}

/// −2 ln L of whitened innovations, up to a constant. Each channel has a level by which its variance
/// is larger than the filter's, never below 1: it takes what no disturbance can express.
pub(crate) fn deviance(levels: &[[f64; 2]; CHANNELS]) -> f64 {
    let of = |[mean, count]: &[f64; 2]| {
        let level = mean.max(1.0);
        count * (level.ln() + mean / level)
    };
    levels.iter().map(of).sum()
}

/// One over the root of its channel's level for each innovation; 0 for what was not measured.
pub(crate) fn weights(whitened: &[f64], channels: &[u8]) -> Vec<f64> {
    by_level(whitened, channels, |level| level.sqrt().recip())
}

/// One over its channel's level for each innovation; 0 for what was not measured.
pub(crate) fn precisions(whitened: &[f64], channels: &[u8]) -> Vec<f64> {
    by_level(whitened, channels, f64::recip)
}

fn by_level(whitened: &[f64], channels: &[u8], of: impl Fn(f64) -> f64) -> Vec<f64> {
    let each = levels(whitened, channels).map(|[mean, _]| of(mean.max(1.0)));
    let own = |channel: &u8| each.get(usize::from(*channel)).copied().unwrap_or(0.0);
    channels.iter().map(own).collect()
}
