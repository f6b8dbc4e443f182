//! One pass of the extended Kalman filter.

use super::derivatives::{Derivatives, Lately, differentiated};
use super::flow::Flow;
use super::update::{Covariance, Gain};
use super::{DISTURBANCES, DISTURBED, N, Noise, Run, SLIP, Sensor, in_order};

/// Factor of an encoder's variance beside an impact of its gear: half a count more.
const IMPACT: f64 = 4.0;
/// Variance of what was not measured: it says nothing.
pub(crate) const NOT_MEASURED: f64 = 1e12;

/// One row of a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passed {
    /// Which row of the run.
    pub(crate) row: usize,
    /// When it was measured (s).
    pub(crate) true_s: f64,
    pub(crate) step: Derivatives,
    /// Measured minus predicted.
    pub(crate) innovation: [f64; 3],
    /// What is left of the disturbances at the next row.
    pub(crate) decay: [f64; DISTURBANCES],
    /// Variance of the sensor's error but for that of its stamp, and how fast what it measures changes.
    pub(crate) variance: [f64; 3],
    pub(crate) rates: [f64; 3],
    /// The state was lost before it.
    pub(crate) lost: bool,
    /// Something pushes after it.
    pub(crate) gusty: bool,
}

impl Passed {
    /// Variance of the sensor's error under `noise`.
    pub(super) fn variance(&self, run: &Run, noise: &Noise) -> [f64; 3] {
        noise.variance(run.rows[self.row].sensor, &self.variance, &self.rates)
    }
}

/// A pass over one run, in the order in which its rows were measured.
#[derive(Debug, Clone)]
pub(crate) struct Pass {
    pub(crate) rows: Vec<Passed>,
    /// Of each row of the run, in the run's order.
    pub(crate) gains: Vec<Gain>,
}

impl Pass {
    /// Filters a run. `None` where the simulation diverges.
    pub(crate) fn new(flow: &Flow<'_>, noise: &Noise) -> Option<Self> {
        if noise.of_wheels {
            Self::of::<N>(flow, noise)
        } else {
            Self::of::<SLIP>(flow, noise)
        }
    }

    fn of<const M: usize>(flow: &Flow<'_>, noise: &Noise) -> Option<Self> {
        let run = flow.run;
        let order = in_order(flow.robot, run);
        let mut covariance = Covariance::<M> {
            p: start_covariance(&run.start_deviation, noise),
        };
        let mut gains = vec![Gain::NONE; run.rows.len()];
        let mut rows = Vec::with_capacity(order.len());
        let mut point = flow.start();
        let mut apart = false;
        let mut lately = Lately::default();
        let mut before_s = f64::INFINITY;
        for (place, &(true_s, index)) in order.iter().enumerate() {
            let row = &run.rows[index];
            let deviation = covariance.deviation();
            let (after, step) = differentiated(flow, &point, true_s, row, &deviation, &mut lately);
            point = after;
            if point.is_lost() {
                return None;
            }
            let innovation = flow.innovation(&point, row);
            let mut variance = row.variance;
            let engaged = point.state.engaged();
            if row.sensor == Sensor::WheelAngle && (engaged != [true; 2] || apart) {
                // when a gear closes is known to a step only
                for v in variance.iter_mut().filter(|v| **v < NOT_MEASURED) {
                    *v *= IMPACT;
                }
                apart = engaged != [true; 2];
            }
            let lost = run.is_lost_between(before_s, true_s);
            if lost {
                covariance.p = start_covariance(&run.lost_deviation, noise);
            }
            before_s = true_s;
            let rates = flow.rates(&point, row);
            let gain = covariance.update(&step, &noise.variance(row.sensor, &variance, &rates));
            let next_s = order.get(place + 1).map_or(true_s, |(next_s, _)| *next_s);
            let decay = noise.decay(next_s - true_s);
            flow.correct(&mut point, &gain.correction(&innovation));
            for (own, a) in point.disturbance.iter_mut().zip(&decay) {
                *own *= a;
            }
            covariance.disturb(noise, &decay);
            let gusty = run.is_gusty(true_s);
            if gusty {
                covariance.push(&run.lost_deviation);
            }
            gains[index] = gain;
            rows.push(Passed {
                row: index,
                true_s,
                step,
                innovation,
                decay,
                variance,
                rates,
                lost,
                gusty,
            });
        }
        Some(Self { rows, gains })
    }
}

/// Covariance of the state where the run begins.
pub(super) fn start_covariance<const M: usize>(
    deviation: &[f64; N],
    noise: &Noise,
) -> [[f64; M]; M] {
    let mut p = [[0.0; M]; M];
    for (i, row) in p.iter_mut().enumerate() {
        row[i] = deviation[i] * deviation[i];
    }
    for (k, size) in noise.size.iter().enumerate() {
        p[DISTURBED + k][DISTURBED + k] = size * size;
    }
    p
}
