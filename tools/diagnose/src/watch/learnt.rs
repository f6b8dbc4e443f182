//! What filters read of a robot as its baseline was fitted, and of the same robot after a small change of each parameter.

use std::sync::Arc;

use crate::data::reference::Thinned;
use crate::data::streams::WheelKind;
use crate::explain::kinematic::Baseline;
use crate::filter::gyro::{self, Gyro};
use crate::filter::wheel_channel::{ChannelNoise, Tails};
use crate::filter::wheels_to_pose::{self, Noise, Physics, WheelsToPose};
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::drive::{
    AVERAGED, DEAD_ZONE, DELAY, DRIVE, FRICTION, GAIN, GAIN_ASYMMETRY, LAG, PULL, SLOW_SHARE,
    slow_s,
};
use crate::model::wheel_parameters::{
    ASYMMETRY, COMMON, DRIVE_FIRST, GYRO_LATENCY, MACHINE, OFFSET_X, OFFSET_Y, OFFSET_YAW,
    POSE_LATENCY, RUN_BIAS, RUN_LATE, RUN_POSE_LATE, TRACK, drive_parameters, gyro_parameters,
    pose_parameters,
};

/// Changes by which filters are differentiated: factors, lengths (m) and angles; latencies of references (s), which are small
/// beside the time between two rows; times of a drive (s), which are as large as those that are looked for, since what is late
/// by more than a drive takes to follow is not seen by a derivative; speeds as a share of the largest.
const FACTOR: f64 = 1e-4;
const LATENCY_S: f64 = 2e-3;
const DRIVE_S: f64 = 0.05;
const SPEED_SHARE: f64 = 1e-3;

/// A number that filters read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Parameter {
    /// Of the machine.
    Machine(usize),
    /// The bias of its gyro.
    Bias,
    /// Of its drive.
    Drive(usize),
}

/// Of these, what may change.
const OF_MACHINE: [usize; 8] = [
    COMMON,
    ASYMMETRY,
    TRACK,
    OFFSET_X,
    OFFSET_Y,
    OFFSET_YAW,
    POSE_LATENCY,
    GYRO_LATENCY,
];
const OF_DRIVE: [usize; 7] = [DELAY, LAG, GAIN, GAIN_ASYMMETRY, DEAD_ZONE, FRICTION, PULL];

/// Which rows are filtered in which of the interleaved series.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Interleaved {
    pub(crate) series: usize,
    stride: usize,
}

impl Interleaved {
    fn of<R>(rows: &Thinned<R>) -> Self {
        let longest = rows.series.first().map_or(1, Vec::len).max(1);
        Self {
            series: rows.series.len().max(1),
            stride: rows.all.len().div_ceil(longest).max(1),
        }
    }

    /// The series of a row; `None` for one that is left out.
    pub(crate) fn of_row(self, row: usize) -> Option<usize> {
        (0..self.series).find(|k| {
            let first = k * self.stride / self.series;
            row >= first && (row - first).is_multiple_of(self.stride)
        })
    }
}

/// A filter's parameters as they were fitted, and after a change of each that it depends on.
pub(crate) struct Moved<P> {
    pub(crate) base: P,
    pub(crate) after: Vec<P>,
    /// Which of all parameters these are, and by how much each was changed.
    pub(crate) places: Vec<usize>,
    pub(crate) steps: Vec<f64>,
}

/// The filter of the poses.
pub(crate) struct Poses {
    pub(crate) interleaved: Interleaved,
    pub(crate) interval_s: f64,
    pub(crate) physics: Moved<Physics<f64>>,
    pub(crate) noise: Noise<f64>,
}

/// The filter of the gyro.
pub(crate) struct Rates {
    pub(crate) interleaved: Interleaved,
    pub(crate) models: Moved<gyro::Model<f64>>,
}

/// The filters of the drive.
pub(crate) struct Driven {
    pub(crate) parameters: Moved<Vec<f64>>,
    pub(crate) noise: [ChannelNoise<f64>; 2],
    pub(crate) kind: WheelKind,
    pub(crate) by_volts: bool,
    /// Largest commanded speed of a wheel (rad/s).
    pub(crate) largest_rad_s: f64,
}

/// What filters read of a robot.
pub(crate) struct Learnt {
    pub(crate) baseline: Arc<Baseline>,
    pub(crate) parameters: Vec<Parameter>,
    /// The drive as which the wheels turn where none were recorded.
    pub(crate) commanded: Option<Moved<Vec<f64>>>,
    pub(crate) poses: Option<Poses>,
    pub(crate) rates: Option<Rates>,
    pub(crate) driven: Option<Driven>,
    /// Latencies (s) of poses and of the gyro.
    latencies_s: [f64; 2],
}

impl Learnt {
    /// What a baseline says of a robot whose parameters are off by `shift` since; 0 where it ends.
    pub(crate) fn new(baseline: Arc<Baseline>, shift: &[f64]) -> Self {
        let fitted = baseline.fitted();
        let at = &baseline.found.selected.fit.at;
        let all = fitted.machine_at(at);
        let mut local =
            mean((0..baseline.machine.runs.len()).map(|run| baseline.machine.local(run, &all)));
        let mut drive = fitted.drive_at(at);
        let parameters = parameters(&baseline);
        for (own, by) in parameters.iter().zip(shift) {
            match (*own, &mut drive) {
                (Parameter::Drive(i), Some(drive)) => drive[i] += by,
                _ => local = moved_local(*own, *by, &local, drive.is_some()),
            }
        }
        let steps: Vec<f64> = parameters.iter().map(|own| step(*own, &baseline)).collect();
        let locals: Vec<Vec<f64>> = parameters
            .iter()
            .zip(&steps)
            .map(|(own, h)| moved_local(*own, *h, &local, drive.is_some()))
            .collect();
        let reads = |own: &[f64]| drive_parameters(own).to_vec();
        let is_commanded = baseline.machine.is_commanded();
        let commanded = is_commanded.then(|| Moved::new(&local, &locals, &steps, reads));
        Self {
            poses: poses(&baseline, &local, &locals, &steps),
            rates: rates(&baseline, &local, &locals, &steps),
            driven: drive
                .zip(baseline.drive.as_ref())
                .map(|(own, drive)| driven(drive, &own, &parameters, &steps)),
            latencies_s: [
                local[POSE_LATENCY] + local[MACHINE + RUN_POSE_LATE],
                local[GYRO_LATENCY] + local[MACHINE + RUN_LATE],
            ],
            commanded,
            parameters,
            baseline,
        }
    }

    /// Which parameters each filter reads.
    pub(crate) fn places(&self) -> [Option<&[usize]>; 4] {
        [
            self.commanded.as_ref().map(|own| &own.places[..]),
            self.poses.as_ref().map(|own| &own.physics.places[..]),
            self.rates.as_ref().map(|own| &own.models.places[..]),
            self.driven.as_ref().map(|own| &own.parameters.places[..]),
        ]
    }

    /// Which of the parameters is the bias of the gyro.
    pub(crate) fn bias(&self) -> Option<usize> {
        self.parameters
            .iter()
            .position(|own| *own == Parameter::Bias)
    }

    /// When (s) a row of poses or of the gyro with this stamp was measured, clocks alike.
    pub(crate) fn measured_s(&self, gyro: bool, stamp_s: f64) -> f64 {
        stamp_s - self.latencies_s[usize::from(gyro)]
    }

    pub(crate) fn pose_filter(&self) -> WheelsToPose<'_> {
        let machine = &self.baseline.machine;
        machine.pose_filter(&machine.runs[0], &[], true)
    }

    pub(crate) fn gyro_filter(&self) -> Gyro<'_> {
        self.baseline.machine.gyro_filter(&[], true)
    }
}

impl<P: PartialEq> Moved<P> {
    /// What `reads` makes of the parameters of a run and of those after each change, of all that make a difference.
    fn new(local: &[f64], locals: &[Vec<f64>], steps: &[f64], reads: impl Fn(&[f64]) -> P) -> Self {
        let base = reads(local);
        let mut own = Self {
            base,
            after: Vec::new(),
            places: Vec::new(),
            steps: Vec::new(),
        };
        for (place, (moved, step)) in locals.iter().zip(steps).enumerate() {
            let after = reads(moved);
            if after != own.base {
                own.after.push(after);
                own.places.push(place);
                own.steps.push(*step);
            }
        }
        own
    }
}

impl<P> Moved<P> {
    fn map<Q>(self, make: impl Fn(&P) -> Q) -> Moved<Q> {
        Moved {
            base: make(&self.base),
            after: self.after.iter().map(make).collect(),
            places: self.places,
            steps: self.steps,
        }
    }
}

/// The mean of vectors of one length.
fn mean(all: impl ExactSizeIterator<Item = Vec<f64>>) -> Vec<f64> {
    let count = all.len().max(1) as f64;
    let sum = all.reduce(|sum, own| sum.iter().zip(&own).map(|(a, b)| a + b).collect());
    let sum = sum.unwrap_or_default();
    sum.into_iter().map(|own| own / count).collect()
}

/// What may change of a machine with these streams.
fn parameters(baseline: &Baseline) -> Vec<Parameter> {
    let machine = &baseline.machine;
    let mut all: Vec<Parameter> = OF_MACHINE.map(Parameter::Machine).to_vec();
    if machine.has_gyro() {
        all.push(Parameter::Bias);
    }
    if baseline.drive.is_some() || machine.is_commanded() {
        let of_volts = |own: &usize| ![FRICTION, PULL].contains(own) || machine.volts.is_some();
        all.extend(OF_DRIVE.into_iter().filter(of_volts).map(Parameter::Drive));
    }
    all
}

/// By how much a parameter is changed.
fn step(own: Parameter, baseline: &Baseline) -> f64 {
    let top = match &baseline.drive {
        Some(drive) => drive.largest_rad_s,
        None => baseline.machine.largest_rad_s(),
    };
    match own {
        Parameter::Machine(POSE_LATENCY | GYRO_LATENCY) => LATENCY_S,
        Parameter::Drive(DELAY | LAG) => DRIVE_S,
        Parameter::Drive(DEAD_ZONE | FRICTION | PULL) => SPEED_SHARE * top,
        _ => FACTOR,
    }
}

/// The parameters of a run after a change; a drive with wheels of its own has its own.
fn moved_local(own: Parameter, step: f64, local: &[f64], has_drive: bool) -> Vec<f64> {
    let mut moved = local.to_vec();
    match own {
        Parameter::Machine(i) => moved[i] += step,
        Parameter::Bias => moved[MACHINE + RUN_BIAS] += step,
        Parameter::Drive(i) if !has_drive => moved[DRIVE_FIRST + i] += step,
        Parameter::Drive(_) => (),
    }
    moved
}

fn poses(baseline: &Baseline, local: &[f64], locals: &[Vec<f64>], steps: &[f64]) -> Option<Poses> {
    let machine = &baseline.machine;
    let run = machine.runs.iter().find(|run| run.pose.is_some())?;
    let filter = machine.pose_filter(run, &[], true);
    // what moves the drive of commanded wheels moves poses, too
    let reads = |own: &[f64]| (pose_parameters(own), drive_parameters(own).to_vec());
    let own = Moved::new(local, locals, steps, reads);
    let noise = wheels_to_pose::noise(&pose_parameters(local)[wheels_to_pose::PHYSICS..]);
    Some(Poses {
        interleaved: Interleaved::of(run.pose.as_ref()?),
        interval_s: run.pose_interval_s(),
        physics: own.map(|(own, _)| filter.physics(own)),
        noise,
    })
}

fn rates(baseline: &Baseline, local: &[f64], locals: &[Vec<f64>], steps: &[f64]) -> Option<Rates> {
    let machine = &baseline.machine;
    let run = machine.runs.iter().find(|run| run.gyro.is_some())?;
    let filter = machine.gyro_filter(&[], true);
    let reads = |own: &[f64]| (gyro_parameters(own), drive_parameters(own).to_vec());
    let own = Moved::new(local, locals, steps, reads);
    Some(Rates {
        interleaved: Interleaved::of(run.gyro.as_ref()?),
        models: own.map(|(own, _)| filter.model(own)),
    })
}

fn driven(drive: &CommandToWheels, own: &[f64], all: &[Parameter], steps: &[f64]) -> Driven {
    let moved = all.iter().zip(steps).map(|(parameter, step)| {
        let mut moved = own.to_vec();
        if let Parameter::Drive(i) = parameter {
            moved[*i] += step;
        }
        moved
    });
    let moved: Vec<Vec<f64>> = moved.collect();
    let run = &drive.runs[0];
    Driven {
        parameters: Moved::new(own, &moved, steps, |own| own[..DRIVE].to_vec()),
        noise: run.noise(own, Tails::Student),
        kind: run.wheels.kind,
        by_volts: run.commands.by_volts,
        largest_rad_s: drive.largest_rad_s,
    }
}

/// Times of a slow response after which it is forgotten, and the longest that is kept (s).
const FORGETS: f64 = 4.0;
const MOST_REMEMBERED_S: f64 = 120.0;

/// How long a drive remembers its commands (s).
pub(crate) fn remembers_s(baseline: &Baseline) -> f64 {
    let fitted = baseline.fitted();
    let at = &baseline.found.selected.fit.at;
    let all = fitted.machine_at(at);
    let drive = fitted.drive_at(at);
    let drive = drive.as_deref().unwrap_or(&all[DRIVE_FIRST..]);
    match drive[SLOW_SHARE] {
        0.0 => 0.0,
        _ => (FORGETS * slow_s(drive)).min(MOST_REMEMBERED_S),
    }
}

/// Of the parameters of a drive, over how long its speeds are means (s).
pub(crate) fn averaged_s(parameters: &[f64]) -> f64 {
    parameters[AVERAGED]
}
