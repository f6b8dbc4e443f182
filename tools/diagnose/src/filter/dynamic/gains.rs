//! One pass of the extended Kalman filter.

use super::derivatives::{Derivatives, Lately, differentiated};
use super::flow::{Flow, Point};
use super::update::{Covariance, Gain};
use super::{DISTURBANCES, DISTURBED, N, Noise, Row, Run, SLIP, Sensor, in_order};

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
        let mut gains = vec![Gain::NONE; run.rows.len()];
        let mut rows = Vec::with_capacity(order.len());
        let mut on = On::<M>::begin(flow, noise);
        for (place, &(true_s, index)) in order.iter().enumerate() {
            let row = &run.rows[index];
            let heard = on.hear(flow, noise, true_s, row)?;
            let next_s = order.get(place + 1).map_or(true_s, |(next_s, _)| *next_s);
            let decay = noise.decay(next_s - true_s);
            on.go_on(noise, &decay);
            let gusty = run.is_disturbed(true_s);
            if gusty {
                on.covariance.push(&run.lost_deviation);
            }
            gains[index] = heard.gain;
            rows.push(Passed {
                row: index,
                true_s,
                step: heard.step,
                innovation: heard.innovation,
                decay,
                variance: heard.variance,
                rates: heard.rates,
                lost: heard.lost,
                gusty,
            });
        }
        Some(Self { rows, gains })
    }
}

/// The filter on its way through a run, with the first M entries of the state unknown.
pub(crate) struct On<const M: usize> {
    pub(crate) point: Point,
    covariance: Covariance<M>,
    /// A gear was apart at the last reading of the wheels.
    apart: bool,
    lately: Lately,
    /// When the last row was measured (s).
    before_s: f64,
}

/// What the filter made of a row.
pub(crate) struct Heard {
    pub(crate) step: Derivatives,
    pub(crate) gain: Gain,
    /// Measured minus predicted.
    pub(crate) innovation: [f64; 3],
    variance: [f64; 3],
    rates: [f64; 3],
    lost: bool,
}

impl<const M: usize> On<M> {
    pub(crate) fn begin(flow: &Flow<'_>, noise: &Noise) -> Self {
        Self {
            point: flow.start(),
            covariance: Covariance {
                p: start_covariance(&flow.run.start_deviation, noise),
            },
            apart: false,
            lately: Lately::default(),
            before_s: f64::INFINITY,
        }
    }

    /// Goes to a row that was measured at `true_s` (s) and hears it. `None` where the simulation diverges.
    pub(crate) fn hear(
        &mut self,
        flow: &Flow<'_>,
        noise: &Noise,
        true_s: f64,
        row: &Row,
    ) -> Option<Heard> {
        let run = flow.run;
        let deviation = self.covariance.deviation();
        let lately = &mut self.lately;
        let (after, step) = differentiated(flow, &self.point, true_s, row, &deviation, lately);
        self.point = after;
        if self.point.is_lost() {
            return None;
        }
        let innovation = flow.innovation(&self.point, row);
        let mut variance = row.variance;
        let engaged = self.point.state.engaged();
        if row.sensor == Sensor::WheelAngle && (engaged != [true; 2] || self.apart) {
            // when a gear closes is known to a step only
            for v in variance.iter_mut().filter(|v| **v < NOT_MEASURED) {
                *v *= IMPACT;
            }
            self.apart = engaged != [true; 2];
        }
        let lost = run.is_lost_between(self.before_s, true_s);
        if lost {
            self.covariance.p = start_covariance(&run.lost_deviation, noise);
        }
        self.before_s = true_s;
        let rates = flow.rates(&self.point, row);
        let of_row = noise.variance(row.sensor, &variance, &rates);
        let gain = self.covariance.update(&step, &of_row);
        flow.correct(&mut self.point, &gain.correction(&innovation));
        Some(Heard {
            step,
            gain,
            innovation,
            variance,
            rates,
            lost,
        })
    }

    /// What is left of the disturbances at the next row, and what is disturbed anew.
    pub(crate) fn go_on(&mut self, noise: &Noise, decay: &[f64; DISTURBANCES]) {
        for (own, a) in self.point.disturbance.iter_mut().zip(decay) {
            *own *= a;
        }
        self.covariance.disturb(noise, decay);
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
