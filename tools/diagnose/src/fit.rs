//! Least squares over all windows: global parameters and each window's own start.
//!
//! The starts are eliminated window by window (Schur complement), so that the price grows with the
//! length of the recording alone. Derivatives are the plant's own, by dual numbers.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use num_dual::DualSVec64;
use slipstream_bus::{ModelError, RobotModel};
use slipstream_sim::{Listed, Robot, lift};

use crate::track::Track;
use crate::window::{LOCALS, Window};

/// Channels: right wheel, left wheel, x, y, yaw.
pub(crate) const CHANNELS: usize = 5;

/// Parameters that one pass through a window differentiates.
const PASS: usize = 12;

/// Global parameters at most.
pub(crate) const GLOBALS: usize = PASS - LOCALS;

type Dual = DualSVec64<PASS>;

/// Which numbers of a list of effects are to be fitted: place in the list and parameter.
pub(crate) type Free = (usize, &'static str);

/// Sums of squares and counts of each channel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Misfit {
    pub(crate) squares: [f64; CHANNELS],
    pub(crate) counts: [f64; CHANNELS],
}

impl Misfit {
    fn add(&mut self, other: &Self) {
        for channel in 0..CHANNELS {
            self.squares[channel] += other.squares[channel];
            self.counts[channel] += other.counts[channel];
        }
    }

    /// χ²: sum of squares in standard deviations.
    pub(crate) fn chi_square(&self) -> f64 {
        self.squares.iter().sum()
    }

    /// −2 ln L of the channels' residuals at their own level, none below `floor` deviations.
    pub(crate) fn deviance(&self, floor: f64) -> f64 {
        let own = self
            .squares
            .iter()
            .zip(self.counts)
            .filter(|(_, count)| *count > 0.0);
        own.map(|(square, count)| count * (square / count).max(floor * floor).ln())
            .sum()
    }

    /// Root mean square of all channels, in standard deviations.
    pub(crate) fn level(&self) -> f64 {
        (self.chi_square() / self.counts.iter().sum::<f64>().max(1.0)).sqrt()
    }
}

/// A model fitted to a track.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) values: Vec<f64>,
    pub(crate) starts: Vec<[f64; LOCALS]>,
    pub(crate) misfit: Misfit,
    /// Standard deviation of each value, at the level of noise that is left.
    pub(crate) deviations: Vec<f64>,
}

/// Normal equations of one window.
struct Normal {
    own: SMatrix<f64, LOCALS, LOCALS>,
    cross: SMatrix<f64, LOCALS, GLOBALS>,
    global: SMatrix<f64, GLOBALS, GLOBALS>,
    own_slope: SVector<f64, LOCALS>,
    global_slope: SVector<f64, GLOBALS>,
    misfit: Misfit,
}

/// What is fitted to what.
pub(crate) struct Problem<'a> {
    pub(crate) track: &'a Track,
    pub(crate) windows: &'a [Window],
    pub(crate) model: &'a RobotModel,
    pub(crate) list: &'a [Listed<f64>],
    pub(crate) free: &'a [Free],
}

impl Problem<'_> {
    fn robot(&self, values: &[f64]) -> Result<Robot<Dual>, ModelError> {
        let lifted = lift(self.list, |place, name, value| {
            let at = self.free.iter().position(|free| *free == (place, name));
            at.map_or(Dual::from_re(value), |at| {
                Dual::from_re(values[at]).derivative(LOCALS + at)
            })
        });
        Robot::assemble(self.model, &lifted)
    }

    fn normal(&self, window: &Window, robot: &Robot<Dual>, start: &[f64; LOCALS]) -> Normal {
        let mut at = 0;
        let start = start.map(|value| {
            at += 1;
            Dual::from_re(value).derivative(at - 1)
        });
        let mut normal = Normal {
            own: SMatrix::zeros(),
            cross: SMatrix::zeros(),
            global: SMatrix::zeros(),
            own_slope: SVector::zeros(),
            global_slope: SVector::zeros(),
            misfit: Misfit::default(),
        };
        window.simulate(self.track, robot, &start, |_, channel, residual| {
            // what is further off than this says no more than that it is off
            let value = residual.re.clamp(-1e6, 1e6);
            let slope = residual.eps.0.unwrap_or_else(SVector::zeros);
            let own = slope.fixed_rows::<LOCALS>(0);
            let global = slope.fixed_rows::<GLOBALS>(LOCALS);
            normal.own += own * own.transpose();
            normal.cross += own * global.transpose();
            normal.global += global * global.transpose();
            normal.own_slope += own * value;
            normal.global_slope += global * value;
            normal.misfit.squares[channel] += value * value;
            normal.misfit.counts[channel] += 1.0;
        });
        normal
    }

    fn normals(&self, values: &[f64], starts: &[[f64; LOCALS]]) -> Option<Vec<Normal>> {
        let robot = self.robot(values).ok()?;
        let normals = self.windows.iter().zip(starts);
        let normals: Vec<Normal> = normals
            .map(|(w, start)| self.normal(w, &robot, start))
            .collect();
        let finite = normals.iter().all(|n| n.misfit.chi_square().is_finite());
        finite.then_some(normals)
    }

    /// Levenberg–Marquardt from `values` and `starts`, `rounds` steps at most.
    pub(crate) fn fit(
        &self,
        values: &[f64],
        starts: &[[f64; LOCALS]],
        rounds: usize,
    ) -> Option<Fit> {
        let mut values = values.to_vec();
        let mut starts = starts.to_vec();
        let mut normals = self.normals(&values, &starts)?;
        let mut damping = 1e-4;
        let mut still = 0;
        for _ in 0..rounds {
            let before: f64 = normals.iter().map(|n| n.misfit.chi_square()).sum();
            let (next_values, next_starts) = self.stepped(&normals, &values, &starts, damping);
            let next = self.normals(&next_values, &next_starts);
            let after = next
                .as_ref()
                .map(|n| n.iter().map(|n| n.misfit.chi_square()).sum::<f64>());
            match (next, after) {
                (Some(next), Some(after)) if after < before => {
                    (values, starts, normals) = (next_values, next_starts, next);
                    damping = (damping * 0.1).max(1e-12);
                    still = if before - after < 1e-7 * before + 1e-3 {
                        still + 1
                    } else {
                        0
                    };
                }
                _ => {
                    damping *= 20.0;
                    still += usize::from(damping > 1e8);
                }
            }
            if still > 1 || damping > 1e10 {
                break;
            }
        }
        let mut misfit = Misfit::default();
        normals.iter().for_each(|normal| misfit.add(&normal.misfit));
        let deviations = self.deviations(&normals, misfit.level().max(1.0));
        Some(Fit {
            values,
            starts,
            misfit,
            deviations,
        })
    }

    /// The normal equations of the globals, with the starts eliminated.
    fn reduced(&self, normals: &[Normal], damping: f64) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.free.len();
        let mut matrix = DMatrix::zeros(count, count);
        let mut slope = DVector::zeros(count);
        for normal in normals {
            let inverse = damped(&normal.own, damping);
            let lever = normal.cross.transpose() * inverse;
            let own = normal.global - lever * normal.cross;
            let rest = normal.global_slope - lever * normal.own_slope;
            matrix += own.view((0, 0), (count, count));
            slope += rest.rows(0, count);
        }
        (matrix, slope)
    }

    fn stepped(
        &self,
        normals: &[Normal],
        values: &[f64],
        starts: &[[f64; LOCALS]],
        damping: f64,
    ) -> (Vec<f64>, Vec<[f64; LOCALS]>) {
        let (mut matrix, slope) = self.reduced(normals, damping);
        for i in 0..self.free.len() {
            matrix[(i, i)] = matrix[(i, i)] * (1.0 + damping) + 1e-30;
        }
        let nothing = DVector::zeros(self.free.len());
        let solved = (!self.free.is_empty())
            .then(|| matrix.lu().solve(&-slope))
            .flatten();
        let step = solved.unwrap_or(nothing);
        let values = values.iter().zip(step.iter()).zip(self.free);
        let mut wide: SVector<f64, GLOBALS> = SVector::zeros();
        let moved: Vec<f64> = values
            .enumerate()
            .map(|(i, ((value, step), (place, name)))| {
                let next = bounded(&self.list[*place], name, value + step);
                wide[i] = next - value;
                next
            })
            .collect();
        let starts = normals.iter().zip(starts).map(|(normal, start)| {
            let slope = normal.own_slope + normal.cross * wide;
            let step = damped(&normal.own, damping) * -slope;
            let mut at = 0;
            start.map(|value| {
                at += 1;
                value + step[at - 1]
            })
        });
        (moved, starts.collect())
    }

    fn deviations(&self, normals: &[Normal], level: f64) -> Vec<f64> {
        let (matrix, _) = self.reduced(normals, 0.0);
        let inverse = if self.free.is_empty() {
            None
        } else {
            matrix.try_inverse()
        };
        (0..self.free.len())
            .map(|i| {
                inverse
                    .as_ref()
                    .map_or(f64::INFINITY, |m| m[(i, i)].max(0.0).sqrt() * level)
            })
            .collect()
    }
}

/// A value kept inside its parameter's bounds.
fn bounded((info, _): &Listed<f64>, name: &str, value: f64) -> f64 {
    use slipstream_sim::effects::Domain;
    let domain = info
        .parameters
        .iter()
        .find(|p| p.name == name)
        .map(|p| p.domain);
    match domain {
        Some(Domain::Number { lower, upper, .. }) => value.clamp(lower, upper),
        _ => value,
    }
}

/// Inverse of a window's own equations. What the window does not show keeps its value.
fn damped(own: &SMatrix<f64, LOCALS, LOCALS>, damping: f64) -> SMatrix<f64, LOCALS, LOCALS> {
    let mut matrix = *own;
    for i in 0..LOCALS {
        matrix[(i, i)] = matrix[(i, i)] * (1.0 + damping) + 1e-9;
    }
    matrix.try_inverse().unwrap_or_else(SMatrix::zeros)
}
