//! All streams of one machine as one likelihood of one vector of parameters.
//!
//! What the filters read (the clock of the poses against that of the wheels, how far a wheel carries, the
//! gain of the drive) is a linear function of the parameters of the catalogue: encoders that count wrong
//! move the gain of the drive and the way of a wheel in opposite directions, late wheels move every clock.
//! So effects compete by what all streams say of them together.

use std::ops::Range;
use std::sync::Mutex;

use nalgebra::DMatrix;
use slipstream_bus::RobotModel;

use super::command_to_wheels::{CommandToWheels, DriveView};
use super::from_wheels::FromWheels;
use super::view::View;
use super::wheel_parameters::DRIVE_FIRST;
use crate::data::command::CommandPath;
use crate::estimate::information::empty;
use crate::estimate::{BlockScore, Likelihood};

/// A command below this is none (rad/s).
const NONE_RAD_S: f64 = 1e-9;

/// The streams of one machine.
#[derive(Clone, Copy)]
pub(crate) struct Streams<'a> {
    /// From wheels (or commands, where no wheels were recorded) to pose and gyro.
    pub(crate) reference: &'a FromWheels,
    /// From commands to wheels, where both were recorded.
    pub(crate) drive: Option<&'a CommandToWheels>,
}

/// One filter's likelihood, the range of what it reads, and the robot of each of its runs.
struct FilterPart<'a> {
    likelihood: Box<dyn Likelihood + 'a>,
    range: Range<usize>,
    robots: Vec<usize>,
    /// What it said last, and of what.
    last: Mutex<(Vec<f64>, Vec<f64>)>,
}

impl FilterPart<'_> {
    /// Log-likelihood of each block; what was asked last is known.
    fn value(&self, all: &[f64]) -> Vec<f64> {
        let own = &all[self.range.clone()];
        if let Ok(last) = self.last.lock()
            && last.0 == own
        {
            return last.1.clone();
        }
        let values = self.likelihood.value(own);
        if let Ok(mut last) = self.last.lock() {
            *last = (own.to_vec(), values.clone());
        }
        values
    }
}

impl<'a> Streams<'a> {
    /// Where the parameters of the drive begin among those that the filters read.
    pub(crate) fn drive_first(&self) -> usize {
        self.reference.parameters()
    }

    /// Where a parameter of the drive stands among those that the filters read.
    pub(crate) fn of_drive(&self, parameter: usize) -> usize {
        match self.drive {
            Some(_) => self.drive_first() + parameter,
            None => DRIVE_FIRST + parameter,
        }
    }

    /// What the filters read under the nominal model.
    pub(crate) fn nominal(&self, model: &RobotModel) -> Vec<f64> {
        let mut all = self.reference.nominal(model);
        all.extend(self.drive.iter().flat_map(|drive| drive.nominal(model)));
        all
    }

    /// Whether runs from before are among them.
    pub(crate) fn compares(&self) -> bool {
        self.reference.before.any() || self.drive.is_some_and(|own| own.before.any())
    }

    /// Whether runs of today are compared row by row with those from before.
    pub(crate) fn is_paired(&self) -> bool {
        self.reference.before.is_paired() || self.drive.is_some_and(|own| own.before.is_paired())
    }

    /// Of each part, its first block of today and its end, among all blocks.
    pub(crate) fn blocks_of_today(&self) -> Vec<[usize; 2]> {
        let span = |ends: &[usize], before: usize, first: usize| {
            let end = ends.last().copied().unwrap_or(0);
            let begin = before.checked_sub(1).map_or(0, |last| ends[last]);
            [first + begin, first + end]
        };
        let reference = self.reference;
        let ends: Vec<usize> = reference.runs.iter().map(|run| run.blocks.end()).collect();
        let mut parts = vec![span(&ends, reference.before.runs, 0)];
        if let Some(drive) = self.drive {
            let first = ends.last().copied().unwrap_or(0);
            let ends: Vec<usize> = drive.runs.iter().map(|run| run.blocks.end()).collect();
            parts.push(span(&ends, drive.before.runs, first));
        }
        parts
    }

    /// Distinct sizes of all commands but 0 (rad/s), rising.
    pub(crate) fn levels_rad_s(&self) -> Vec<f64> {
        let paths: Vec<&CommandPath> = match self.drive {
            Some(drive) => drive.runs.iter().map(|run| &run.commands).collect(),
            None => {
                let runs = self.reference.runs.iter();
                runs.filter_map(|run| run.wheels.commands()).collect()
            }
        };
        let all = paths
            .iter()
            .flat_map(|path| path.speeds_rad_s.iter().flatten());
        let sizes = all
            .map(|speed| speed.abs())
            .filter(|size| *size > NONE_RAD_S);
        let mut levels: Vec<f64> = sizes.collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|a, b| (*a - *b).abs() < NONE_RAD_S);
        levels
    }

    fn parts(&self, [robust, robust_drive]: [bool; 2]) -> Vec<FilterPart<'a>> {
        let machine = self.reference;
        let middle = self.drive_first();
        let mut parts = vec![FilterPart {
            likelihood: Box::new(View { machine, robust }),
            range: 0..middle,
            robots: machine.runs.iter().map(|run| run.robot).collect(),
            last: Mutex::default(),
        }];
        if let Some(drive) = self.drive {
            parts.push(FilterPart {
                likelihood: Box::new(DriveView {
                    drive,
                    robust: robust_drive,
                }),
                range: middle..middle + drive.parameters(),
                robots: drive.runs.iter().map(|run| run.robot).collect(),
                last: Mutex::default(),
            });
        }
        parts
    }
}

/// What the filters read with these parameters.
pub(crate) fn read(nominal: &[f64], weights: &[Vec<(usize, f64)>], at: &[f64]) -> Vec<f64> {
    let mut all = nominal.to_vec();
    for (own, value) in weights.iter().zip(at) {
        for (index, weight) in own {
            all[*index] += weight * value;
        }
    }
    all
}

/// Rows of all streams may be outliers.
pub(crate) const ROBUST: [bool; 2] = [true; 2];

/// The likelihood of all streams.
pub(crate) struct Joint<'a> {
    parts: Vec<FilterPart<'a>>,
    /// What the filters read under the nominal model.
    nominal: &'a [f64],
    /// How each parameter moves it.
    weights: &'a [Vec<(usize, f64)>],
    clusters: Option<Vec<usize>>,
}

impl<'a> Joint<'a> {
    /// The likelihood of `streams`; `robust`: rows of the reference, and of the drive, may be outliers. Without, it
    /// is smoother: a start.
    pub(crate) fn new(
        streams: Streams<'a>,
        nominal: &'a [f64],
        weights: &'a [Vec<(usize, f64)>],
        robust: [bool; 2],
    ) -> Self {
        let parts = streams.parts(robust);
        let clusters = clusters(&parts);
        Self {
            parts,
            nominal,
            weights,
            clusters,
        }
    }

    fn read(&self, at: &[f64]) -> Vec<f64> {
        read(self.nominal, self.weights, at)
    }

    /// Of what a part reads that `free` parameters move: its places, and how they are moved.
    fn moved(&self, range: &Range<usize>, free: &[usize]) -> (Vec<usize>, DMatrix<f64>) {
        let mut places: Vec<usize> = Vec::new();
        let mut entries = Vec::new();
        for (column, parameter) in free.iter().enumerate() {
            let own = self.weights[*parameter].iter();
            for (index, weight) in own.filter(|(index, _)| range.contains(index)) {
                let place = index - range.start;
                let line = places.iter().position(|p| *p == place);
                let line = line.unwrap_or_else(|| {
                    places.push(place);
                    places.len() - 1
                });
                entries.push((line, column, *weight));
            }
        }
        let mut map = DMatrix::zeros(places.len(), free.len());
        for (line, column, weight) in entries {
            map[(line, column)] += weight;
        }
        (places, map)
    }
}

/// The cluster of each block of all parts, where some err together.
fn clusters(parts: &[FilterPart<'_>]) -> Option<Vec<usize>> {
    let err_together = |part: &FilterPart<'_>| part.likelihood.clusters().is_some();
    if !parts.iter().any(err_together) {
        return None;
    }
    let mut all: Vec<usize> = Vec::new();
    for part in parts {
        let first = all.iter().max().map_or(0, |last| last + 1);
        match part.likelihood.clusters() {
            Some(own) => all.extend(own.iter().map(|cluster| first + cluster)),
            None => all.extend((0..part.likelihood.blocks()).map(|block| first + block)),
        }
    }
    Some(all)
}

impl Likelihood for Joint<'_> {
    fn blocks(&self) -> usize {
        self.parts.iter().map(|part| part.likelihood.blocks()).sum()
    }

    fn run_of(&self) -> Vec<usize> {
        let of = |part: &FilterPart<'_>| -> Vec<usize> {
            let runs = part.likelihood.run_of().into_iter();
            runs.map(|run| part.robots[run]).collect()
        };
        self.parts.iter().flat_map(of).collect()
    }

    fn clusters(&self) -> Option<&[usize]> {
        self.clusters.as_deref()
    }

    fn apart(&self, at: &[f64]) -> f64 {
        let all = self.read(at);
        let parts = self
            .parts
            .iter()
            .filter(|part| part.likelihood.blocks() > 0);
        let each = parts.map(|part| part.likelihood.apart(&all[part.range.clone()]));
        each.reduce(f64::max).unwrap_or(1.0)
    }

    fn loosen(&self, at: &mut [f64]) {
        let before = self.read(at);
        let mut all = before.clone();
        for part in &self.parts {
            part.likelihood.loosen(&mut all[part.range.clone()]);
        }
        for (own, value) in self.weights.iter().zip(at) {
            if let [(index, weight)] = own.as_slice() {
                *value += (all[*index] - before[*index]) / weight;
            }
        }
    }

    fn is_shared(&self, parameter: usize) -> bool {
        self.weights[parameter].iter().all(|(index, _)| {
            let part = self.parts.iter().find(|part| part.range.contains(index));
            part.is_some_and(|own| own.likelihood.is_shared(index - own.range.start))
        })
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        use rayon::prelude::*;
        let all = self.read(at);
        let each = self.parts.par_iter();
        let each = each.map(|part| part.value(&all));
        each.collect::<Vec<Vec<f64>>>().concat()
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let all = self.read(at);
        let mut scores = Vec::new();
        for part in &self.parts {
            let (places, map) = self.moved(&part.range, free);
            if places.is_empty() {
                scores.extend(empty(part.likelihood.blocks(), free.len()));
                continue;
            }
            let own = part.likelihood.score(&all[part.range.clone()], &places);
            scores.extend(own.into_iter().map(|block| BlockScore {
                gradient: map.transpose() * block.gradient,
                information: map.transpose() * block.information * &map,
            }));
        }
        scores
    }
}
