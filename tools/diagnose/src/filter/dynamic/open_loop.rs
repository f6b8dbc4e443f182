//! What noise makes of predictions with nothing heard after their first part: the covariance of a pass,
//! carried on without updates.

use super::gains::{NOT_MEASURED, Pass, start_covariance};
use super::update::Covariance;
use super::{N, Noise, ROLLING, Run, SLIP, Sensor};
use crate::data::track::{CHANNELS, Sensor as Stream};

/// Sums of variances without those of the sensors, and counts, of each channel.
pub(crate) type Sums = [[f64; 2]; CHANNELS];

/// Adds the variances by which process noise and starts displace the rows of a pass, predicted over windows of
/// `horizon_s` whose start is fitted to their first `fitted_s` (s).
pub(crate) fn add_variances(
    run: &Run,
    pass: &Pass,
    noise: &Noise,
    [horizon_s, fitted_s]: [f64; 2],
    sums: &mut Sums,
) {
    if noise.of_wheels {
        add::<N>(run, pass, noise, [horizon_s, fitted_s], sums);
    } else {
        add::<SLIP>(run, pass, noise, [horizon_s, fitted_s], sums);
    }
}

fn add<const M: usize>(
    run: &Run,
    pass: &Pass,
    noise: &Noise,
    [horizon_s, fitted_s]: [f64; 2],
    sums: &mut Sums,
) {
    let start = |deviation| Covariance::<M> {
        p: start_covariance(deviation, noise),
    };
    let mut covariance = start(&run.start_deviation);
    let mut from_s = run.begin_s;
    for row in &pass.rows {
        if row.true_s >= from_s + horizon_s || row.lost {
            covariance = start(&run.lost_deviation);
            from_s = row.true_s;
        }
        if row.true_s < from_s + fitted_s {
            covariance.update(&row.step, &row.variance(run, noise));
        } else {
            let variance = covariance.unheard(&row.step, &row.variance);
            let first = match run.rows[row.row].sensor {
                Sensor::WheelAngle | Sensor::WheelSpeed => Stream::WheelAngle,
                Sensor::Pose => Stream::Pose,
                Sensor::Imu => Stream::Imu,
            };
            let first = first.channel();
            for (part, own) in variance.into_iter().enumerate() {
                if row.variance[part] < NOT_MEASURED
                    && let Some([sum, count]) = sums.get_mut(first + part)
                {
                    *sum += own - row.variance[part];
                    *count += 1.0;
                }
            }
            for part in 0..2 {
                let [sum, count] = &mut sums[Stream::Odometry.channel() + part];
                *sum += covariance.p[ROLLING + part][ROLLING + part];
                *count += 1.0;
            }
        }
        covariance.disturb(noise, &row.decay);
        if row.gusty {
            covariance.push(&run.lost_deviation);
        }
    }
}
