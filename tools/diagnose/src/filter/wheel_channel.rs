//! Kalman filter of one wheel channel (sum or difference of both wheels) about its simulated course.
//!
//! The drive is linear behind its static map, so that measured minus simulated is itself a linear
//! series: an integrated Ornstein-Uhlenbeck disturbance of the speed, a random walk of the angle, and
//! sensor noise with the error of its stamps. Innovations are Student's t with 5 degrees of freedom:
//! robust, and still nine tenths as sharp (Lange, Little and Taylor 1989).
//!
//! Such tails hide physics from a search that begins with them: where most rows are steady and exact,
//! these fix a tiny scale, and the rows behind each step, which alone know a lag, are outliers without a
//! slope. A search therefore begins with normal innovations and grows the tails behind them (graduated
//! non-convexity; Blake and Zisserman 1987).

use slipstream_sim::Scalar;

use super::Innovation;
use super::ornstein_uhlenbeck::{Integrated, OrnsteinUhlenbeck};

/// Degrees of freedom.
const FREEDOM: f64 = 5.0;
/// ln of the normalisation of Student's t with 5 degrees of freedom and unit variance:
/// Γ(3) / (Γ(5/2) √(3 π)).
const LOG_NORMALISATION: f64 = -0.713_206_777_171_729;
/// ln √(2 π).
const LOG_ROOT_TAU: f64 = 0.918_938_533_204_672_7;
/// Least variance of an innovation (rad²).
const LEAST_VARIANCE: f64 = 1e-16;

/// How probable large innovations are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tails {
    /// Normal: every row counts in full.
    Normal,
    /// Student's t: a row far from what is predicted counts little.
    Student,
}

/// One row of a channel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChannelRow<S> {
    pub(crate) time_s: f64,
    /// Measured minus simulated: angle (rad), or speed (rad/s).
    pub(crate) rest: S,
    /// Simulated speed (rad/s): what an error of the stamp displaces.
    pub(crate) speed_rad_s: S,
    /// Whether its innovation is evidence.
    pub(crate) counts: bool,
}

/// Sizes of the noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChannelNoise<S> {
    /// Deviation (rad/s) and time (s) of the disturbance.
    pub(crate) disturbance_rad_s: S,
    pub(crate) time_s: S,
    /// Random walk of the angle (rad/√s).
    pub(crate) walk: S,
    /// Sensor noise (rad, or rad/s), and of its stamps (s).
    pub(crate) sensor: S,
    pub(crate) stamp_s: S,
    pub(crate) tails: Tails,
}

impl<S: Scalar> ChannelNoise<S> {
    fn disturbance(&self) -> OrnsteinUhlenbeck<S> {
        OrnsteinUhlenbeck {
            variance: self.disturbance_rad_s * self.disturbance_rad_s,
            time_s: self.time_s,
        }
    }
}

/// Innovation of a scalar row.
fn innovation<S: Scalar>(
    row: &ChannelRow<S>,
    tails: Tails,
    difference: S,
    variance: S,
) -> Innovation<S> {
    let zero = S::constant(0.0);
    let z = difference * difference / variance;
    let (surprise, weight) = match tails {
        Tails::Normal => (z * 0.5 + LOG_ROOT_TAU, 1.0),
        Tails::Student => (
            (z * (1.0 / (FREEDOM - 2.0)) + 1.0).ln() * ((FREEDOM + 1.0) * 0.5) - LOG_NORMALISATION,
            (FREEDOM + 1.0) / (FREEDOM - 2.0 + z.value()),
        ),
    };
    let log_likelihood = (variance.ln() * 0.5 + surprise) * -1.0;
    Innovation {
        time_s: row.time_s,
        weight: f64::from(u8::from(row.counts)),
        scalar: true,
        ordinary: weight,
        log_likelihood,
        difference: [difference, zero, zero],
        covariance: [[variance, zero, zero], [zero; 3], [zero; 3]],
    }
}

/// A channel on its way.
#[derive(Clone)]
pub(crate) struct On<S> {
    pub(crate) state: Integrated<S>,
    last_s: f64,
}

impl<S: Scalar> ChannelNoise<S> {
    /// The filter behind the first row of a channel of angles.
    pub(crate) fn begin(&self, first: &ChannelRow<S>) -> On<S> {
        let zero = S::constant(0.0);
        let sensor = self.sensor * self.sensor;
        On {
            state: Integrated {
                mean: [first.rest, zero],
                cov: [sensor + LEAST_VARIANCE, zero, self.disturbance().variance],
            },
            last_s: first.time_s,
        }
    }

    /// Moves on to a row of angles and hears it.
    pub(crate) fn hear_angle(&self, on: &mut On<S>, row: &ChannelRow<S>) -> Innovation<S> {
        let sensor = self.sensor * self.sensor;
        let disturbance = self.disturbance();
        let h = row.time_s - std::mem::replace(&mut on.last_s, row.time_s);
        let step = disturbance.step(S::constant(h));
        let q = disturbance.noise(&step, S::constant(h));
        on.state.advance(&step);
        let [xx, xd, dd] = on.state.cov;
        on.state.cov = [xx + q[0] + self.walk * self.walk * h, xd + q[1], dd + q[2]];
        let shift = self.stamp_s * row.speed_rad_s;
        let variance = on.state.cov[0] + sensor + shift * shift + LEAST_VARIANCE;
        let difference = row.rest - on.state.mean[0];
        on.state = on.state.updated(difference, variance);
        innovation(row, self.tails, difference, variance)
    }

    /// Hears a row of speeds; the first one, too. The disturbance is the second entry of the state.
    pub(crate) fn hear_speed(&self, on: &mut Option<On<S>>, row: &ChannelRow<S>) -> Innovation<S> {
        let sensor = self.sensor * self.sensor;
        let disturbance = self.disturbance();
        let zero = S::constant(0.0);
        let on = match on {
            Some(on) => {
                let h = row.time_s - std::mem::replace(&mut on.last_s, row.time_s);
                let decay = disturbance.step(S::constant(h)).decay;
                on.state.mean[1] *= decay;
                on.state.cov[2] = on.state.cov[2] * decay * decay
                    + disturbance.variance * (S::constant(1.0) - decay * decay);
                on
            }
            None => on.insert(On {
                state: Integrated {
                    mean: [zero; 2],
                    cov: [zero, zero, disturbance.variance],
                },
                last_s: row.time_s,
            }),
        };
        let (d, p) = (&mut on.state.mean[1], &mut on.state.cov[2]);
        let shift = self.stamp_s * row.speed_rad_s;
        let variance = *p + sensor + shift * shift + LEAST_VARIANCE;
        let difference = row.rest - *d;
        let gain = *p / variance;
        *d += gain * difference;
        let taken = gain * *p;
        *p -= taken;
        innovation(row, self.tails, difference, variance)
    }
}

/// Filters a channel of angles. `after` hears time and disturbance (rad/s) behind every row.
pub(crate) fn angles<S: Scalar>(
    rows: impl Iterator<Item = ChannelRow<S>>,
    noise: &ChannelNoise<S>,
    sink: &mut dyn FnMut(Innovation<S>),
    after: &mut dyn FnMut(f64, S),
) {
    let mut on: Option<On<S>> = None;
    for row in rows {
        let own = match &mut on {
            Some(own) => {
                sink(noise.hear_angle(own, &row));
                own
            }
            None => on.insert(noise.begin(&row)),
        };
        after(row.time_s, own.state.mean[1]);
    }
}

/// The same for a channel of speeds.
pub(crate) fn speeds<S: Scalar>(
    rows: impl Iterator<Item = ChannelRow<S>>,
    noise: &ChannelNoise<S>,
    sink: &mut dyn FnMut(Innovation<S>),
    after: &mut dyn FnMut(f64, S),
) {
    let mut on = None;
    for row in rows {
        sink(noise.hear_speed(&mut on, &row));
        after(
            row.time_s,
            on.as_ref()
                .map_or(S::constant(0.0), |own| own.state.mean[1]),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three rows of a random walk with sensor noise the innovations are those of the textbook.
    #[test]
    fn a_random_walk_is_filtered_as_by_hand() {
        let noise = ChannelNoise {
            disturbance_rad_s: 1e-9,
            time_s: 1.0,
            walk: 0.3,
            sensor: 0.2,
            stamp_s: 0.0,
            tails: Tails::Student,
        };
        let rows = [(0.0, 1.0), (1.0, 1.5), (3.0, 1.2)].map(|(time_s, rest)| ChannelRow {
            time_s,
            rest,
            speed_rad_s: 0.0,
            counts: true,
        });
        let mut seen: Vec<(f64, f64)> = Vec::new();
        angles(
            rows.into_iter(),
            &noise,
            &mut |own| seen.push((own.difference[0], own.covariance[0][0])),
            &mut |_, _| (),
        );
        let p = 0.04 + 0.09;
        let s = p + 0.04;
        let x = 1.0 + p / s * 0.5;
        let next = p - p * p / s + 0.18 + 0.04;
        for ((e, v), (wanted_e, wanted_v)) in seen.iter().zip([(0.5, s), (1.2 - x, next)]) {
            assert!(
                (e - wanted_e).abs() < 1e-9 && (v - wanted_v).abs() < 1e-9,
                "{e} {v}"
            );
        }
    }
}
