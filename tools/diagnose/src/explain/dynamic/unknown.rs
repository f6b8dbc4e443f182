//! What the catalogue does not hold: a force that follows a variable, looked for through the stored
//! derivatives of a pass, then refitted with its own noise.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use slipstream_bus::{EffectSpec, Parameter};

use super::drivers::Driver;
use crate::answer::shape::resemblance;
use crate::estimate::Likelihood;
use crate::estimate::scoring::SHORT;
use crate::filter::dynamic::columns::{Load, columns};
use crate::model::plant::channels::precisions;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::likelihood::Plant;
use crate::model::plant::machine::Machine;
use crate::model::plant::table::Table;

/// Half width of a 95 % interval of a normal distribution (deviations).
const NORMAL: f64 = 1.96;
/// Share of what is due that a force has to promise at the noise without it.
const PROMISE: f64 = 0.25;
/// Drivers that are refitted with their noise.
const LEADERS: usize = 4;
/// Gain (−2 ln L) from which on a force is linearised again, at the sharper gains.
/// How often it is linearised again at most, and the gain (−2 ln L) below which that ends.
const LINEARISED: usize = 5;
const LITTLE: f64 = 3.0;
const AGAIN: f64 = 15.0;
/// Share of the largest force from which on it counts as at work, and the gap that does not part an
/// interval (s).
const AT_WORK: f64 = 0.5;
const GAP_S: f64 = 0.25;

/// A force outside of the catalogue.
pub(crate) struct Unknown {
    pub(crate) driver: &'static str,
    pub(crate) channel: &'static str,
    /// The fit under it.
    pub(crate) fit: Filtered,
    /// Log-likelihood of each block there (nats).
    pub(crate) by_block: Vec<f64>,
    /// Gain in −2 ln L, and how many numbers it took.
    pub(crate) gain: f64,
    pub(crate) numbers: usize,
    /// When it is large (s), in the first run.
    pub(crate) intervals_s: Vec<[f64; 2]>,
    /// What it looks like.
    pub(crate) shape: String,
    /// Its largest force along the body (N) and moment (N m).
    pub(crate) largest: [f64; 2],
    /// As a model lists it, where it can.
    pub(crate) spec: Option<EffectSpec>,
    /// The same as knots and values, and half widths of 95 % intervals of the values.
    pub(crate) table: Option<(Vec<f64>, Vec<f64>)>,
    pub(crate) half: Vec<f64>,
}

/// A driver with the factors of its functions.
struct FittedDriver<'a> {
    driver: &'a Driver,
    factors: Vec<f64>,
    /// Deviations of the factors.
    deviations: Vec<f64>,
    gain: f64,
}

/// What is fitted already: its effects, and its noise with which a force begins.
pub(crate) struct Beside<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) table: &'a Table,
    pub(crate) at: &'a [f64],
    pub(crate) fit: &'a Filtered,
}

/// A machine under a force, and what is fitted there.
struct Under {
    machine: Machine,
    at: Vec<f64>,
    fit: Filtered,
    by_block: Vec<f64>,
}

impl Beside<'_> {
    /// The force that gains most, if one promises a share of what is `due` (−2 ln L).
    pub(crate) fn unknown(&self, due: f64) -> Option<Unknown> {
        let moments = self.machine.moments(self.fit)?;
        let drivers = self.machine.drivers(&moments);
        let mut fitted: Vec<FittedDriver<'_>> = drivers
            .par_iter()
            .filter_map(|driver| self.machine.linear(self.fit, driver))
            .collect();
        fitted.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut seen: Vec<&str> = Vec::new();
        fitted.retain(|own| {
            let new = !seen.contains(&own.driver.name);
            seen.push(own.driver.name);
            new
        });
        fitted.truncate(LEADERS);
        fitted.retain(|own| own.gain > PROMISE * due);
        let refitted = fitted.par_iter().filter_map(|own| self.refitted(own));
        refitted.max_by(|a, b| {
            let score = |own: &Unknown| own.gain - 2.0 * own.numbers as f64;
            score(a).total_cmp(&score(b))
        })
    }

    /// A force with its own noise; linearised again while that gains.
    fn refitted(&self, own: &FittedDriver<'_>) -> Option<Unknown> {
        let mut factors = own.factors.clone();
        let mut under = self.under(self.at, own.driver, &factors)?;
        let gain = self.fit.deviance - under.fit.deviance;
        let promising = gain - 2.0 * factors.len() as f64 > AGAIN;
        for _ in 0..if promising { LINEARISED } else { 0 } {
            let Some(more) = under.machine.linear(&under.fit, own.driver) else {
                break;
            };
            let pairs = factors.iter().zip(&more.factors);
            let moved: Vec<f64> = pairs.map(|(a, b)| a + b).collect();
            let Some(next) = self.under(&under.at, own.driver, &moved) else {
                break;
            };
            let gain = under.fit.deviance - next.fit.deviance;
            if gain < 0.0 {
                break;
            }
            (under, factors) = (next, moved);
            if gain < LITTLE {
                break;
            }
        }
        let loads = load(own.driver, &factors);
        Some(Unknown {
            driver: own.driver.name,
            channel: own.driver.channel,
            gain: self.fit.deviance - under.fit.deviance,
            numbers: factors.len(),
            largest: largest(loads.iter().flatten()),
            intervals_s: at_work(&under.fit, &loads[0]),
            shape: shape(own.driver, &loads, &factors),
            spec: spec(own.driver, &factors),
            half: own.deviations.iter().map(|d| NORMAL * d).collect(),
            table: own
                .driver
                .table
                .as_ref()
                .map(|(_, knots)| (knots.clone(), factors.clone())),
            by_block: under.by_block,
            fit: under.fit,
        })
    }

    /// The machine under a force with these factors, and the noise there.
    fn under(&self, at: &[f64], driver: &Driver, factors: &[f64]) -> Option<Under> {
        let mut machine = self.machine.clone();
        machine.add_loads(self.fit, &load(driver, factors));
        let plant = Plant::new(&machine, self.table);
        let fit = self.table.problem(&plant).fit(at, &self.table.told, SHORT);
        let filtered = plant.filtered(&fit.at)?.as_ref().clone();
        let by_block = plant.value(&fit.at);
        Some(Under {
            at: fit.at,
            fit: filtered,
            by_block,
            machine,
        })
    }
}

impl Machine {
    /// The factors that fit best, were the innovations linear in them.
    fn linear<'a>(&self, fit: &Filtered, driver: &'a Driver) -> Option<FittedDriver<'a>> {
        let count = driver.functions.len();
        let mut all: Vec<Vec<f64>> = vec![Vec::with_capacity(self.channels.len()); count];
        for (run, pass) in fit.passes.iter().enumerate() {
            let own: Vec<Vec<Load>> = driver.functions.iter().map(|f| f[run].clone()).collect();
            for (all, own) in all
                .iter_mut()
                .zip(columns(pass, &own, self.runs[run].rows.len()))
            {
                all.extend(own);
            }
        }
        let precisions = precisions(&fit.whitened, &self.channels);
        let dot = |a: &[f64], b: &[f64]| {
            let products = a
                .iter()
                .zip(b)
                .zip(&precisions)
                .map(|((x, y), p)| x * y * p);
            products.sum::<f64>()
        };
        let mut normal = DMatrix::from_fn(count, count, |i, k| {
            if k <= i { dot(&all[i], &all[k]) } else { 0.0 }
        });
        normal.fill_upper_triangle_with_lower_triangle();
        let ridge = 1e-6 * normal.trace() / count as f64 + 1e-12;
        for i in 0..count {
            normal[(i, i)] += ridge;
        }
        let gradient = DVector::from_fn(count, |i, _| dot(&all[i], &fit.whitened));
        let factor = normal.cholesky()?;
        let factors = -factor.solve(&gradient);
        let gain = -factors.dot(&gradient);
        let deviations = factor.inverse().diagonal().map(f64::sqrt);
        Some(FittedDriver {
            driver,
            deviations: deviations.iter().copied().collect(),
            factors: factors.iter().copied().collect(),
            gain: gain - 2.0 * count as f64,
        })
    }
}

/// The load of a driver at each row of the pass of each run.
fn load(driver: &Driver, factors: &[f64]) -> Vec<Vec<Load>> {
    let runs = driver.functions.first().map_or(0, Vec::len);
    (0..runs)
        .map(|run| {
            let rows = driver.functions[0][run].len();
            (0..rows)
                .map(|q| {
                    let parts = driver.functions.iter().zip(factors);
                    parts.fold([0.0; 2], |[along, about], (function, factor)| {
                        let [x, y] = function[run][q];
                        [along + factor * x, about + factor * y]
                    })
                })
                .collect()
        })
        .collect()
}

/// The largest force and moment of loads.
fn largest<'a>(loads: impl Iterator<Item = &'a Load>) -> [f64; 2] {
    loads.fold([0.0, 0.0], |most: [f64; 2], load| {
        [0, 1].map(|i| most[i].max(load[i].abs()))
    })
}

/// When a load of the first run is large (s).
fn at_work(fit: &Filtered, loads: &[Load]) -> Vec<[f64; 2]> {
    let largest = largest(loads.iter());
    let large =
        |load: &Load| (0..2).any(|i| largest[i] > 0.0 && load[i].abs() > AT_WORK * largest[i]);
    let mut intervals: Vec<[f64; 2]> = Vec::new();
    for (row, load) in fit.passes[0].rows.iter().zip(loads) {
        if large(load) {
            match intervals.last_mut() {
                Some(own) if row.true_s - own[1] < GAP_S => own[1] = row.true_s,
                _ => intervals.push([row.true_s, row.true_s]),
            }
        }
    }
    intervals
}

/// What a load looks like, in words.
fn shape(driver: &Driver, loads: &[Vec<Load>], factors: &[f64]) -> String {
    let part = usize::from(driver.channel == "yaw");
    let (what, unit) = if part == 0 {
        ("force along the body", "N")
    } else {
        ("moment about the vertical", "N m")
    };
    let values = loads.iter().flatten().map(|load| load[part]);
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    let name = driver.name.replace('_', " ");
    let table = driver.table.as_ref();
    let near = table.and_then(|(_, knots)| resemblance(driver.name, knots, factors));
    let near = near.map_or(String::new(), |near| format!("; {near}"));
    format!("a {what} that depends on {name}, from {low:.3} to {high:.3} {unit}{near}")
}

/// A table over a driver as a model lists it.
fn spec(driver: &Driver, factors: &[f64]) -> Option<EffectSpec> {
    let (acts_on, knots) = driver.table.as_ref()?;
    let text = |word: &str| Parameter::Text(word.to_owned());
    let mut spec = EffectSpec::new("force_law", &[]);
    spec.parameters = vec![
        ("acts_on".to_owned(), text(acts_on)),
        ("driver".to_owned(), text(driver.name)),
        ("knots".to_owned(), Parameter::List(knots.clone())),
        ("values".to_owned(), Parameter::List(factors.to_vec())),
    ];
    Some(spec)
}
