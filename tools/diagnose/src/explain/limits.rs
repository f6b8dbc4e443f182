//! From which size on an effect that was not found would have been seen, of a machine that is told speeds
//! or nothing: beside the findings, by its deviation.

use super::prediction::{Errors, Predictor};
use super::scene::{Scene, some_windows};
use super::sight::{self, SIGMAS};
use super::terms;
use crate::answer::{Limit, Seen};
use crate::estimate::scoring::{Fit, Problem};
use crate::model::drive::{CLOCK, DELAY, DRIVE, GAIN, GAIN_ASYMMETRY, LAG, SAG};
use crate::model::from_wheels::{
    ASYMMETRY, COMMON, DRIVE_FIRST, GYRO_LATENCY, GYRO_RATE, LAW_FIRST, OFFSET_X, OFFSET_Y,
    OFFSET_YAW, POSE_LATENCY, POSE_RATE, RUN_SCALE, RUN_TRACK, TRACK, View,
};
use crate::select::elimination::{LEAST_APART, Selected, Term};

/// Windows by which the error of a limit is predicted.
const WINDOWS: usize = 12;

/// One parameter of the catalogue.
struct Named {
    effect: &'static str,
    word: Option<&'static str>,
    parameter: &'static str,
    unit: &'static str,
    /// A factor: its logarithm is fitted.
    is_factor: bool,
}

/// The limits of all terms that no finding has.
pub(super) fn limits(scene: &Scene<'_>) -> Vec<Limit> {
    let base = Base::new(scene);
    let mut limits = calibrated(scene, &base);
    limits.extend(driven(scene, &base));
    let error = |limit: &Limit| limit.error[0].or(limit.error[1]).unwrap_or(0.0);
    limits.sort_by(|a, b| error(b).total_cmp(&error(a)));
    limits
}

fn calibrated(scene: &Scene<'_>, base: &Base) -> Vec<Limit> {
    let Some(calibration) = scene.calibration else {
        return Vec::new();
    };
    // beside recordings from before: what a change would have to be
    let (machine, nominal, found, by_run) = match &calibration.joint {
        Some(own) => (&own.machine, own.nominal.as_slice(), &own.after, [false; 2]),
        None => {
            let by_run = calibration.by_run;
            (scene.machine, scene.nominal, &calibration.after, by_run)
        }
    };
    let view = View {
        machine,
        robust: true,
    };
    let problem = machine.problem(&view, nominal);
    let all = terms::terms(machine, scene.excluded, by_run);
    let laws = terms::laws(machine, scene.excluded);
    let all: Vec<Term> = all.into_iter().chain(laws).collect();
    of_terms((scene, base), &problem, found, &all, 0)
}

fn driven(scene: &Scene<'_>, base: &Base) -> Vec<Limit> {
    let own = scene.predictors.iter().any(|own| own.drive.is_some());
    let (Some(drive), true) = (scene.drive, own) else {
        return Vec::new();
    };
    let joint = drive.joint.as_deref();
    let of_joint = || Some((scene.joint_drive?, joint?));
    let Some((machine, drive)) = of_joint().or_else(|| Some((scene.driven?, drive))) else {
        return Vec::new();
    };
    let problem = machine.problem(machine, &drive.nominal);
    let all = super::drive_terms::terms_of(machine, scene.excluded);
    of_terms((scene, base), &problem, &drive.after, &all, DRIVE_FIRST)
}

/// The limits of those of `all` that were not kept; parameters of the fit begin at `first` of the machine's.
fn of_terms(
    (scene, base): (&Scene<'_>, &Base),
    problem: &Problem<'_>,
    found: &Selected,
    all: &[Term],
    first: usize,
) -> Vec<Limit> {
    let judged = all
        .iter()
        .filter(|term| !term.by_profile && !super::drive_terms::is_nuisance(term));
    let apart = problem.likelihood.apart(&found.fit.at).max(LEAST_APART);
    let claimed = |index: &usize| {
        scene
            .claims
            .iter()
            .any(|claim| claim.toggles.contains(index))
    };
    let mut limits = Vec::new();
    for term in judged {
        // radii and track are one term: what no finding has of it is ruled out as well
        let named: Vec<(usize, Named)> = term
            .parameters
            .iter()
            .filter(|index| !claimed(&(first + **index)))
            .filter_map(|index| Some((*index, named(scene, first + index)?)))
            .collect();
        if named.is_empty() {
            continue;
        }
        let deviations = match found.kept(term.name) {
            Some(_) => Some(
                term.parameters
                    .iter()
                    .map(|i| found.deviation(&[(*i, 1.0)]))
                    .collect(),
            ),
            None => deviations(problem, &found.fit, term),
        };
        for (index, named) in named {
            let deviation = deviations.as_ref().and_then(|own: &Vec<f64>| {
                let place = term.parameters.iter().position(|p| *p == index)?;
                let floor = apart * (term.floors[place] + term.unnoticed[place]);
                let variance = own[place] * own[place] * term.caution * term.caution + floor;
                variance.is_finite().then(|| variance.sqrt())
            });
            limits.push(limit((scene, base), &named, first + index, deviation));
        }
    }
    limits
}

/// Deviations of the parameters of a term beside what was found.
fn deviations(problem: &Problem<'_>, fit: &Fit, term: &Term) -> Option<Vec<f64>> {
    let precision = sight::beside(problem, fit, term)?;
    let variances = (0..term.parameters.len()).map(|i| precision.covariance[(i, i)]);
    Some(variances.map(f64::sqrt).collect())
}

fn limit(
    (scene, base): (&Scene<'_>, &Base),
    named: &Named,
    index: usize,
    deviation: Option<f64>,
) -> Limit {
    let change = deviation.map(|own| SIGMAS * own);
    let error = change.map_or([None, None], |change| base.caused(scene, index, change));
    let nothing = if named.is_factor { 1.0 } else { 0.0 };
    Limit {
        effect: named.effect,
        word: named.word,
        parameter: named.parameter,
        unit: named.unit,
        seen: if named.is_factor {
            Seen::Around(nothing)
        } else {
            Seen::Above
        },
        size: change.map(|change| {
            if named.is_factor {
                change.exp_m1()
            } else {
                change
            }
        }),
        usual: 1.0,
        error,
    }
}

/// Some windows of each run as the findings predict them: what a change is compared with.
struct Base {
    runs: Vec<(Vec<[f64; 2]>, Errors)>,
}

impl Base {
    fn new(scene: &Scene<'_>) -> Self {
        let most = WINDOWS.div_ceil(scene.predictors.len());
        let runs = scene.predictors.iter().enumerate().map(|(run, predictor)| {
            let windows = some_windows(predictor, most);
            let errors = predictor.errors(run, scene.fitted, &windows, true);
            (windows, errors)
        });
        Self {
            runs: runs.collect(),
        }
    }

    /// Root mean square by which predictions change with this parameter: place (m) and heading (rad).
    fn caused(&self, scene: &Scene<'_>, index: usize, change: f64) -> [Option<f64>; 2] {
        let mut moved = scene.fitted.to_vec();
        moved[index] += change;
        let [mut place, mut turn] = [[0.0_f64; 2]; 2];
        let runs = scene.predictors.iter().zip(&self.runs).enumerate();
        for (run, (predictor, (windows, own))) in runs {
            let other = predictor.errors(run, &moved, windows, true);
            let pairs = own.predicted.iter().zip(&other.predicted);
            for ((ax, ay), (bx, by)) in pairs.filter(|(p, _)| p.0.is_finite()) {
                place = [
                    place[0] + (ax - bx).powi(2) + (ay - by).powi(2),
                    place[1] + 1.0,
                ];
            }
            let ends = turns(predictor, own).into_iter();
            for (a, b) in ends.zip(turns(predictor, &other)) {
                turn = [turn[0] + (a - b).powi(2), turn[1] + 1.0];
            }
        }
        [place, turn].map(|[squares, count]| (count > 0.0).then(|| (squares / count).sqrt()))
    }
}

/// Errors of the heading.
fn turns(predictor: &Predictor<'_>, errors: &Errors) -> Vec<f64> {
    if !predictor.run.has_heading() {
        return Vec::new();
    }
    let own = errors
        .residuals
        .iter()
        .filter(|(_, channel, _)| *channel == 4);
    own.map(|(_, _, residual)| *residual)
        .filter(|residual| residual.is_finite())
        .collect()
}

/// What a parameter of the machine is called in the catalogue.
fn named(scene: &Scene<'_>, index: usize) -> Option<Named> {
    let plain = |effect, parameter, unit| Named {
        effect,
        word: None,
        parameter,
        unit,
        is_factor: false,
    };
    let factor = |effect, parameter| Named {
        is_factor: true,
        ..plain(effect, parameter, "1")
    };
    let rate = |word| Named {
        word: Some(word),
        ..plain("clock_drift", "rate", "s/s")
    };
    let of_run = |parameter: usize| {
        let runs = 0..scene.machine.runs.len();
        runs.into_iter()
            .any(|run| scene.machine.of_run(run, parameter) == index)
    };
    let drive = DRIVE_FIRST..DRIVE_FIRST + DRIVE;
    Some(match index {
        COMMON => factor("wheel_radius", "both wheels"),
        ASYMMETRY => factor("wheel_radius", "right over left"),
        TRACK => factor("track_width", "scale"),
        OFFSET_X => plain("pose_offset", "x_m", "m"),
        OFFSET_Y => plain("pose_offset", "y_m", "m"),
        OFFSET_YAW => plain("pose_offset", "yaw_rad", "rad"),
        POSE_LATENCY => plain("pose_latency", "latency_s", "s"),
        POSE_RATE => rate("pose"),
        GYRO_LATENCY => plain("imu_latency", "latency_s", "s"),
        GYRO_RATE => rate("imu"),
        LAW_FIRST => plain("motion_law", "speed over w", "m/s"),
        own if own == LAW_FIRST + crate::filter::motion_law::VALUES[0] => {
            plain("motion_law", "speed over v", "m/s")
        }
        own if drive.contains(&own) => match own - DRIVE_FIRST {
            DELAY => plain("actuator_delay", "delay_s", "s"),
            LAG => plain("actuator_lag", "time_constant_s", "s"),
            GAIN => factor("motor_gain", "both wheels"),
            GAIN_ASYMMETRY => factor("motor_gain", "right over left"),
            SAG => plain("supply_sag", "rate_per_s", "1/s"),
            CLOCK => rate("wheels"),
            _ => return None,
        },
        _ if of_run(RUN_SCALE) => Named {
            word: None,
            ..plain("slip_ratio", "ratio", "1")
        },
        _ if of_run(RUN_TRACK) => factor("track_width", "scale"),
        _ => return None,
    })
}
