//! What a drive shows may be the robot or its encoders: commands against wheels cannot tell a late
//! command from late wheels. Pose and gyro, which hear of neither, decide: each hypothesis is put into
//! the calibration and the likelihoods are compared.

use super::calibration::Calibration;
use super::drive::DriveFit;
use super::term::{
    CLOCK_TERM, DELAY_TERM, GAIN_TERM, GEOMETRY, GYRO_CLOCK, GYRO_LATE, POSE_CLOCK, POSE_LATE,
};
use crate::estimate::Prior;
use crate::estimate::scoring::FULL;
use crate::model::drive::{CLOCK, DELAY, GAIN, GAIN_ASYMMETRY};
use crate::model::from_wheels::{
    ASYMMETRY, COMMON, FromWheels, GYRO_LATENCY, GYRO_RATE, POSE_LATENCY, POSE_RATE, TRACK, View,
};
use crate::select::criterion::{Criterion, TIE_NATS};
use crate::select::elimination::Selected;

/// Logarithms of the factor from which on a gain is far from 1, and of what one factor differs by.
const FAR_LN: f64 = std::f64::consts::LN_2;
const SAME_LN: f64 = 0.03;

/// What may be the encoders'.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Doubt {
    /// Late wheels, or a late command.
    Delay,
    /// Encoders that count wrong, or a gain of the motors.
    Gain,
    /// The wheels' clock, or something that the drive alone shows.
    Clock,
}

/// A doubt that was settled.
#[derive(Debug, Clone)]
pub(crate) struct Settled {
    pub(crate) doubt: Doubt,
    /// It is the encoders'.
    pub(crate) is_wheels: bool,
    /// The references cannot really tell.
    pub(crate) tie: bool,
    /// What it adds to parameters of the calibration, if it is the encoders'.
    pub(crate) shifts: Vec<(usize, f64)>,
}

/// Settles every doubt that the drive raises.
pub(crate) fn settle(
    machine: &FromWheels,
    nominal: &[f64],
    calibration: &Calibration,
    drive: &DriveFit,
) -> Vec<Settled> {
    let change = |index: usize| drive.after.fit.at[index] - drive.nominal[index];
    let late = change(DELAY);
    let clock = change(CLOCK);
    let deviation = |index: usize| drive.after.deviation(&[(index, 1.0)]);
    // what is in doubt, its term of the drive, rival terms of the calibration, shifts, what they are known to
    type Row<'a> = (Doubt, &'a str, &'a [&'a str], Vec<(usize, f64)>, [f64; 2]);
    let doubts: [Row<'_>; 3] = [
        (
            Doubt::Delay,
            DELAY_TERM,
            &[POSE_LATE, GYRO_LATE],
            vec![(POSE_LATENCY, -late), (GYRO_LATENCY, -late)],
            [deviation(DELAY); 2],
        ),
        (
            Doubt::Gain,
            GAIN_TERM,
            &[GEOMETRY],
            vec![
                (COMMON, -change(GAIN)),
                (ASYMMETRY, -change(GAIN_ASYMMETRY)),
            ],
            [GAIN, GAIN_ASYMMETRY].map(deviation),
        ),
        (
            Doubt::Clock,
            CLOCK_TERM,
            &[POSE_CLOCK, GYRO_CLOCK],
            vec![(POSE_RATE, -clock), (GYRO_RATE, -clock)],
            [deviation(CLOCK); 2],
        ),
    ];
    let raised = doubts
        .into_iter()
        .filter(|(_, term, ..)| drive.after.kept(term).is_some());
    raised
        .map(|(doubt, _, rivals, shifts, known)| {
            // scales of single runs take up whatever encoders do
            let by_run = doubt == Doubt::Gain && calibration.by_run[0];
            let advantage = match &calibration.joint {
                _ if by_run => 0.0,
                Some(own) => {
                    let fitted = (&own.after, calibration.criterion);
                    let known = Some(known);
                    advantage(&own.machine, &own.nominal, fitted, rivals, (&shifts, known))
                }
                None => {
                    let fitted = (&calibration.after, calibration.criterion);
                    advantage(machine, nominal, fitted, rivals, (&shifts, None))
                }
            };
            let undone =
                doubt == Doubt::Gain && !by_run && is_undone(nominal, calibration, change(GAIN));
            Settled {
                doubt,
                is_wheels: advantage > 0.0 || undone,
                tie: advantage.abs() < TIE_NATS && !undone,
                shifts,
            }
        })
        .collect()
}

/// Whether a gain far from 1 (its logarithm) is undone by the reference: motors and wheels that are both off
/// by one factor, in opposite directions, would be a coincidence.
fn is_undone(nominal: &[f64], calibration: &Calibration, gain: f64) -> bool {
    let scale = calibration.after.fit.at[COMMON] - nominal[COMMON];
    gain.abs() > FAR_LN && (scale + gain).abs() < SAME_LN
}

/// Log-likelihood by which the calibration with `shifts` is better than the one without; the rivals'
/// parameters that it makes needless count as the criterion says. Shifts are exact, or `known` to these
/// deviations: runs on one course know them better than the drive.
fn advantage(
    machine: &FromWheels,
    nominal: &[f64],
    (own, criterion): (&Selected, Criterion),
    rivals: &[&str],
    (shifts, known): (&[(usize, f64)], Option<[f64; 2]>),
) -> f64 {
    let view = View {
        machine,
        robust: true,
    };
    let mut problem = machine.problem(&view, nominal);
    let fixed = |index: &usize| shifts.iter().any(|(shifted, _)| shifted == index);
    let mut at = own.fit.at.clone();
    for (index, shift) in shifts {
        at[*index] = nominal[*index] + shift;
    }
    let mut free: Vec<usize> = own.fit.free.iter().filter(|i| !fixed(i)).copied().collect();
    for ((index, _), deviation) in shifts.iter().zip(known.into_iter().flatten()) {
        problem.priors[*index] = Prior {
            mean: at[*index],
            deviation,
        };
        free.push(*index);
    }
    // what stood in for it may not be needed any more
    let kept = || rivals.iter().filter_map(|name| own.kept(name));
    let mut spare = at.clone();
    for index in kept().flat_map(|kept| &kept.term.parameters) {
        if !fixed(index) {
            spare[*index] = nominal[*index];
        }
    }
    let mut loose = spare.clone();
    problem.likelihood.loosen(&mut loose);
    let fits = [at, spare, loose].map(|start| problem.fit(&start, &free, FULL).objective);
    let best = fits.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let spared: usize = kept()
        .map(|kept| {
            let parameters = kept.term.parameters.iter();
            parameters.filter(|i| **i != TRACK && fixed(i)).count()
        })
        .sum();
    let worth = if spared > 0 {
        criterion.least_gain(spared)
    } else {
        0.0
    };
    best - own.fit.objective + worth
}
