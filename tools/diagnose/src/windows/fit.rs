//! A model fitted to windows: shared parameters and each window's own start, by Levenberg and
//! Marquardt with differences in place of derivatives. The plant in `f64` is ten to forty times as
//! fast as with four derivatives carried along, so that differences are the cheaper way to them.

use rayon::prelude::*;
use slipstream_bus::{InputError, RobotModel};
use slipstream_sim::effects::Domain;
use slipstream_sim::{ListedEffect, Robot, lift};

use crate::windows::hypothesis::{
    KINETIC, STATIC, come_round, is_bound_to_place, is_limit, least_probe,
};
use crate::windows::law::Law;
use crate::windows::linear::{self, Linear, Normal};
use crate::windows::misfit::Misfit;
use crate::windows::simulate::Simulation;
use crate::windows::track::{Sensor, Track};
use crate::windows::window::{LOCALS, Window};
use crate::windows::work::Work;

/// Which numbers of a list of effects are fitted: place in the list and parameter.
pub(crate) type Free = (usize, &'static str);

/// Steps of the differences for surge (m/s) and yaw rate (rad/s) at a window's start.
const START_STEP: [f64; 2] = [1e-4, 1e-3];

/// Change of a residual (deviations) that a difference aims at: far above rounding and the search
/// for events, far below where the plant bends.
const AIM: f64 = 0.3;

/// A fit has arrived where a step brings less than this (−2 ln L), or less than this share of what is
/// left.
const ARRIVED: f64 = 0.02;
const SHARE: f64 = 1e-4;

/// A model fitted to tracks.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) values: Vec<f64>,
    pub(crate) starts: Vec<[f64; LOCALS]>,
    pub(crate) misfit: Misfit,
    /// Standard deviation of each value.
    pub(crate) deviations: Vec<f64>,
    /// Every window to first order around the fit.
    pub(crate) linear: Vec<Linear>,
}

/// What is fitted to what.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub(crate) tracks: &'a [Track],
    pub(crate) windows: &'a [Window],
    pub(crate) model: &'a RobotModel,
    pub(crate) list: &'a [ListedEffect<f64>],
    /// To which track an effect belongs alone.
    pub(crate) only: &'a [Option<usize>],
    pub(crate) free: &'a [Free],
    pub(crate) step_s: f64,
    pub(crate) law: Option<&'a Law>,
    pub(crate) work: &'a Work,
}

/// Where a fit stands.
struct Place {
    values: Vec<f64>,
    starts: Vec<[f64; LOCALS]>,
    residuals: Vec<Vec<f64>>,
    misfit: Misfit,
}

impl<'a> Problem<'a> {
    /// The same with other parameters free. Those that are not keep the values of the list.
    pub(crate) fn with_free(&self, free: &'a [Free]) -> Self {
        Self { free, ..*self }
    }

    /// The same on other windows.
    pub(crate) fn over<'b>(&'b self, windows: &'b [Window]) -> Problem<'b> {
        Problem { windows, ..*self }
    }

    /// The robot of each track.
    pub(crate) fn robots(&self, values: &[f64]) -> Result<Vec<Robot>, InputError> {
        let number = |place: usize, name: &str, value: f64| {
            let at = self.free.iter().position(|free| *free == (place, name));
            at.map_or(value, |at| values[at])
        };
        let list = lift(self.list, |place, name, value| {
            let own = number(place, name, value);
            if name != STATIC {
                return own;
            }
            // what sticks holds at least what slides
            let kinetic = self.list[place].1.get(KINETIC).unwrap_or(0.0);
            own.max(number(place, KINETIC, kinetic))
        });
        (0..self.tracks.len())
            .map(|run| {
                let own = list.iter().zip(self.only);
                let own = own.filter(|(_, only)| only.is_none_or(|only| only == run));
                let own: Vec<ListedEffect<f64>> = own.map(|(listed, _)| listed.clone()).collect();
                Robot::assemble(self.model, &own).map(Robot::draft)
            })
            .collect()
    }

    pub(crate) fn simulation<'b>(
        &'b self,
        window: &'b Window,
        robots: &'b [Robot],
    ) -> Simulation<'b> {
        Simulation {
            track: &self.tracks[window.run],
            window,
            robot: &robots[window.run],
            step_s: self.step_s,
            law: self.law,
            work: self.work,
        }
    }

    /// Residuals of every window, `None` for a robot that cannot be.
    pub(crate) fn residuals(
        &self,
        values: &[f64],
        starts: &[[f64; LOCALS]],
    ) -> Option<Vec<Vec<f64>>> {
        let robots = self.robots(values).ok()?;
        let windows = self.windows.par_iter().zip(starts);
        Some(
            windows
                .map(|(w, start)| self.simulation(w, &robots).residuals(start))
                .collect(),
        )
    }

    fn place(&self, values: Vec<f64>, starts: Vec<[f64; LOCALS]>) -> Option<Place> {
        let residuals = self.residuals(&values, &starts)?;
        let misfit = Misfit::new(self.windows, &residuals);
        misfit.deviance().is_finite().then_some(Place {
            values,
            starts,
            residuals,
            misfit,
        })
    }

    /// Bounds of a free parameter.
    fn bounds(&self, (place, name): Free) -> [f64; 2] {
        let info = self.list[place].0;
        match info.parameter(name).map(|p| p.domain) {
            Some(Domain::Number { lower, upper, .. }) => [lower, upper],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// First steps of the differences for each free parameter.
    pub(crate) fn first_steps(&self, values: &[f64]) -> Vec<f64> {
        let of = |(i, (place, name)): (usize, &Free)| {
            let info = self.list[*place].0;
            let size = least_probe(info, name);
            0.01 * size.unwrap_or_else(|| values[i].abs().max(0.1))
        };
        self.free.iter().enumerate().map(of).collect()
    }

    /// How residuals move with each parameter from `first` on; `steps` are adapted to what is seen.
    pub(crate) fn columns(
        &self,
        values: &[f64],
        starts: &[[f64; LOCALS]],
        residuals: &[Vec<f64>],
        steps: &mut [f64],
        first: usize,
    ) -> Option<Vec<Vec<Vec<f64>>>> {
        let columns: Option<Vec<(Vec<Vec<f64>>, f64)>> = (first..self.free.len())
            .into_par_iter()
            .map(|i| self.column(values, starts, residuals, steps[i], i))
            .collect();
        let mut all = Vec::new();
        for (i, (column, step)) in columns?.into_iter().enumerate() {
            steps[first + i] = step;
            all.push(column);
        }
        Some(all)
    }

    fn column(
        &self,
        values: &[f64],
        starts: &[[f64; LOCALS]],
        residuals: &[Vec<f64>],
        step: f64,
        i: usize,
    ) -> Option<(Vec<Vec<f64>>, f64)> {
        let mut step = step;
        let [lower, upper] = self.bounds(self.free[i]);
        let mut columns = Vec::new();
        for _ in 0..3 {
            let mut moved = values.to_vec();
            let inside = !is_limit(self.list[self.free[i].0].0) && values[i] + step <= upper;
            moved[i] = if inside {
                values[i] + step
            } else {
                (values[i] - step).max(lower)
            };
            let change = moved[i] - values[i];
            let after = self.residuals(&moved, starts)?;
            columns = difference(residuals, &after, change);
            // a first-order change, root mean square over what moves most
            let moves = size(self.windows, &columns) * change.abs();
            let wanted = step * (AIM / moves.max(1e-9)).clamp(1e-3, 30.0);
            let far = !(0.02..=20.0).contains(&(moves / AIM));
            step = wanted.min(0.2 * values[i].abs().max(5.0 * step));
            if !far {
                break;
            }
        }
        Some((columns, step))
    }

    /// How residuals of each window move with its start.
    fn locals(&self, values: &[f64], place: &Place) -> Option<Vec<Vec<Vec<f64>>>> {
        let robots = self.robots(values).ok()?;
        let bound_to_place = self.list.iter().any(|(info, _)| is_bound_to_place(info));
        let windows = self
            .windows
            .par_iter()
            .zip(&place.starts)
            .zip(&place.residuals);
        let columns = windows.map(|((window, start), residuals)| {
            let simulation = self.simulation(window, &robots);
            let mut columns = rigid(&self.tracks[window.run], window, start, residuals);
            let stepped = |i: usize, step: f64| {
                let mut moved = *start;
                moved[i] += step;
                let after = simulation.residuals(&moved);
                let pairs = after.iter().zip(residuals);
                pairs
                    .map(|(after, before)| (after - before) / step)
                    .collect::<Vec<f64>>()
            };
            if bound_to_place && window.free[2] {
                columns[2] = stepped(2, 1e-4);
            }
            if window.free[3] {
                columns[3] = stepped(3, START_STEP[0]);
                columns[4] = stepped(4, START_STEP[1]);
            }
            columns
        });
        Some(columns.collect())
    }

    fn linear(&self, place: &Place, steps: &mut [f64]) -> Option<Vec<Linear>> {
        let locals = self.locals(&place.values, place)?;
        let globals = self.columns(&place.values, &place.starts, &place.residuals, steps, 0)?;
        let windows = locals.into_iter().enumerate();
        let linear = windows.map(|(w, locals)| Linear {
            residuals: place.residuals[w].clone(),
            locals,
            globals: globals.iter().map(|column| column[w].clone()).collect(),
        });
        Some(linear.collect())
    }

    pub(crate) fn normals(&self, linear: &[Linear], misfit: &Misfit) -> Vec<Normal> {
        let weights = misfit.weights();
        let windows = self.windows.iter().zip(linear);
        windows
            .map(|(window, linear)| linear.normal(window, &weights, &linear.residuals, &[]))
            .collect()
    }

    /// Levenberg and Marquardt from `values` and `starts`, `rounds` steps at most.
    pub(crate) fn fit(
        &self,
        values: &[f64],
        starts: &[[f64; LOCALS]],
        rounds: usize,
    ) -> Option<Fit> {
        let mut place = self.place(values.to_vec(), starts.to_vec())?;
        let mut steps = self.first_steps(values);
        let mut linear = self.linear(&place, &mut steps)?;
        let mut damping = 1e-4;
        for round in 0..rounds {
            let normals = self.normals(&linear, &place.misfit);
            let before = place.misfit.deviance();
            let mut next = None;
            for _ in 0..6 {
                let (values, starts) = self.stepped(&normals, &place, damping);
                next = self
                    .place(values, starts)
                    .filter(|next| next.misfit.deviance() < before);
                if next.is_some() {
                    damping = (damping * 0.1).max(1e-9);
                    break;
                }
                damping = (damping * 10.0).max(1e-4);
            }
            let Some(next) = next else { break };
            let gained = before - next.misfit.deviance();
            place = next;
            let done = gained < ARRIVED.max(SHARE * before) || round + 1 == rounds;
            linear = self.linear(&place, &mut steps)?;
            if done {
                break;
            }
        }
        let residuals: Vec<&[f64]> = place.residuals.iter().map(Vec::as_slice).collect();
        place.misfit.remember(self.windows, &residuals);
        let normals = self.normals(&linear, &place.misfit);
        Some(Fit {
            deviations: linear::deviations(&normals, place.misfit.excess()),
            values: place.values,
            starts: place.starts,
            misfit: place.misfit,
            linear,
        })
    }

    /// The step of a parameter, cut where its bounds are.
    pub(crate) fn bounded(&self, i: usize, value: f64, step: f64) -> f64 {
        let [lower, upper] = self.bounds(self.free[i]);
        (value + step).clamp(lower, upper) - value
    }

    fn stepped(
        &self,
        normals: &[Normal],
        place: &Place,
        damping: f64,
    ) -> (Vec<f64>, Vec<[f64; LOCALS]>) {
        let step = linear::step(normals, damping, |i, step| {
            self.bounded(i, place.values[i], step)
        });
        let pairs = place.values.iter().zip(&step.globals).zip(self.free);
        let values = pairs.map(|((value, step), (at, name))| {
            let info = self.list[*at].0;
            come_round(info, name, value + step)
        });
        let starts = place.starts.iter().zip(&step.locals).map(|(start, step)| {
            let mut moved = *start;
            moved.iter_mut().zip(step).for_each(|(m, s)| *m += s);
            moved
        });
        (values.collect(), starts.collect())
    }
}

fn difference(before: &[Vec<f64>], after: &[Vec<f64>], step: f64) -> Vec<Vec<f64>> {
    let windows = before.iter().zip(after);
    windows
        .map(|(before, after)| {
            let pairs = before.iter().zip(after);
            pairs.map(|(b, a)| (a - b) / step).collect()
        })
        .collect()
}

/// Root mean square of a column over the channel in which it is largest.
fn size(windows: &[Window], columns: &[Vec<f64>]) -> f64 {
    Misfit::new(windows, columns).worst().1
}

/// How residuals move with the pose and the angles at the start, as of a rigid body: exact where
/// nothing depends on the place.
fn rigid(
    track: &Track,
    window: &Window,
    start: &[f64; LOCALS],
    residuals: &[f64],
) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; residuals.len()]; LOCALS];
    for (at, series) in track.series.iter().enumerate() {
        let [first, end] = window.rows[at];
        for (k, (_, values)) in series.rows[first..end].iter().enumerate() {
            let base = window.base[at] + k * series.sensor.width();
            let deviation = series.deviation;
            match series.sensor {
                Sensor::WheelAngle => {
                    columns[5][base] = 1.0 / deviation[0];
                    columns[6][base + 1] = 1.0 / deviation[1];
                }
                Sensor::Pose => {
                    let seen = [0, 1].map(|i| values[i] + residuals[base + i] * deviation[i]);
                    columns[0][base] = 1.0 / deviation[0];
                    columns[1][base + 1] = 1.0 / deviation[1];
                    columns[2][base] = -(seen[1] - start[1]) / deviation[0];
                    columns[2][base + 1] = (seen[0] - start[0]) / deviation[1];
                    columns[2][base + 2] = 1.0 / deviation[2];
                }
                _ => {}
            }
        }
    }
    columns.iter_mut().for_each(|column| window.share(column));
    columns
}
