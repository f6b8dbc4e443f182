//! Sweep: an experiment at every combination of values of some of its keys, with the built-in controller or programs.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use slipstream_bus::InputError;
use slipstream_launch::{
    LaunchError, Options, Request, Resolved, RunStatus, RunSummary, describe, in_process,
    processes, resolve,
};

use crate::StudyError;

/// Largest number of points of a sweep.
const MAX_POINTS: usize = 100_000;

/// What is swept.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The experiment, with what is the same at all points.
    pub request: Request,
    /// Keys with their values; every combination is a point.
    pub keys: Vec<(String, Vec<String>)>,
    /// Number of runs at each point; the seeds are 1, 2, …
    pub runs: u32,
    /// Number of threads for points without programs. Runs with programs are one after the other: each has its own processes.
    pub threads: usize,
    /// The program that plays the roles of a run.
    pub program: PathBuf,
    /// Says what went wrong in a run.
    pub notice: fn(&str),
}

/// The results of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Version of this format.
    pub format: u32,
    /// The experiment's name.
    pub experiment: String,
    /// Number of runs at each point.
    pub runs: u32,
    /// The points; the values of the last key vary fastest.
    pub points: Vec<Point>,
    /// Whether it was interrupted: only the points finished before are present.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub interrupted: bool,
}

/// The combined results of the runs of one point. Maxima are over all runs; times and gains are means over the runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The swept keys with their values, as they were given.
    pub set: BTreeMap<String, String>,
    /// The largest desired speed of a follower before limiting (m/s).
    pub max_desired_speed_m_s: Option<f64>,
    /// The largest true spacing error (m).
    pub max_spacing_error_m: Option<f64>,
    /// The largest ratio of a follower's largest true spacing error to that of the follower ahead.
    pub string_gain: Option<f64>,
    /// The largest ratio of a follower's largest desired speed to that of the robot ahead: above 1, speeds grow along the
    /// platoon.
    pub speed_gain: Option<f64>,
    /// How long contacts slid, summed over all robots and wheels (s).
    pub slip_time_s: f64,
    /// Share of the sent messages that were lost (1).
    pub lost: f64,
}

/// Runs a sweep. Once `stop` is set no further run begins; the sweep then holds the points finished so far.
///
/// # Errors
/// A point that cannot be run, or a run that fails.
pub fn sweep(plan: &Plan, stop: &AtomicBool) -> Result<Sweep, StudyError> {
    if plan.runs == 0 {
        return Err(InputError::new("--runs", "is 0", "give at least 1").into());
    }
    let cells = cells(&plan.keys)?;
    let resolved = cells
        .iter()
        .map(|cell| prepared(plan, cell))
        .collect::<Result<Vec<Resolved>, InputError>>()?;
    let bar = ProgressBar::new(cells.len() as u64 * u64::from(plan.runs));
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left") {
        bar.set_style(style);
    }
    let has_programs = resolved.iter().any(|own| !own.programs.is_empty());
    let threads = if has_programs { 1 } else { plan.threads };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.max(1))
        .build()?;
    let point =
        |(cell, resolved): (&PointValues, &Resolved)| point(plan, cell, resolved, &bar, stop);
    let points: Result<Vec<Option<Point>>, StudyError> =
        pool.install(|| cells.par_iter().zip(&resolved).map(point).collect());
    bar.finish_and_clear();
    let points: Vec<Point> = points?.into_iter().flatten().collect();
    let name = resolved
        .first()
        .map(|own| own.experiment.settings.name.clone());
    Ok(Sweep {
        format: 1,
        experiment: name.unwrap_or_default(),
        runs: plan.runs,
        interrupted: points.len() < cells.len(),
        points,
    })
}

/// The values of one point.
type PointValues = Vec<(String, String)>;

/// Every combination; the last key varies fastest.
fn cells(keys: &[(String, Vec<String>)]) -> Result<Vec<PointValues>, InputError> {
    let mut cells: Vec<PointValues> = vec![Vec::new()];
    for (key, values) in keys {
        if cells.len() * values.len() > MAX_POINTS {
            let remedy = format!("give shorter lists: at most {MAX_POINTS} points");
            return Err(InputError::new(
                "--set",
                "has too many combinations",
                remedy,
            ));
        }
        let with = |cell: &PointValues| {
            let cell = cell.clone();
            let value = move |value: &String| {
                let mut own = cell.clone();
                own.push((key.clone(), value.clone()));
                own
            };
            values.iter().map(value).collect::<Vec<PointValues>>()
        };
        cells = cells.iter().flat_map(with).collect();
    }
    Ok(cells)
}

/// The experiment of a point, whose programs have described their controllers.
fn prepared(plan: &Plan, cell: &PointValues) -> Result<Resolved, InputError> {
    let mut request = plan.request.clone();
    request.set.extend(cell.iter().cloned());
    // At a point with the built-in controller in place of a program, the program's parameters have no meaning.
    for (key, _) in cell.iter().filter(|(_, value)| value.is_empty()) {
        if let Some(name) = key.strip_prefix("agents.") {
            let parameters = format!("controller.{name}.");
            request.set.retain(|(key, _)| !key.starts_with(&parameters));
        }
    }
    let mut resolved = resolve(&request)?;
    describe(&mut resolved, &|said| (plan.notice)(said))?;
    Ok(resolved)
}

/// Runs a point; `None` if it was stopped before its last run.
fn point(
    plan: &Plan,
    cell: &PointValues,
    resolved: &Resolved,
    bar: &ProgressBar,
    stop: &AtomicBool,
) -> Result<Option<Point>, StudyError> {
    let mut runs = Vec::new();
    let mut resolved = resolved.clone();
    for seed in 1..=plan.runs {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        resolved.experiment.settings.seed = seed.into();
        let run = run_once(plan, &resolved)?;
        match &run.status {
            RunStatus::Done => runs.push(run),
            RunStatus::Interrupted => {
                stop.store(true, Ordering::Relaxed);
                return Ok(None);
            }
            RunStatus::Failed(reason) => {
                let values = cell.iter().map(|(key, value)| format!("{key}={value}"));
                let place = values.collect::<Vec<_>>().join(" ");
                return Err(StudyError::Failed(format!(
                    "{place}, seed {seed}: {reason}"
                )));
            }
        }
        bar.inc(1);
    }
    Ok(Some(Point::new(cell, &runs)))
}

fn run_once(plan: &Plan, resolved: &Resolved) -> Result<RunSummary, StudyError> {
    if resolved.programs.is_empty() {
        return Ok(in_process::summary(resolved, None)?);
    }
    let options = Options {
        program: plan.program.clone(),
        out: None,
        live: false,
        serve: None,
        across: None,
        real: None,
        // What fails is the error of the sweep.
        notice: |_| (),
    };
    processes::run(resolved, &options).map_err(|error| match error {
        LaunchError::Input(error) => error.into(),
        other => StudyError::Failed(other.to_string()),
    })
}

impl Point {
    fn new(cell: &PointValues, runs: &[RunSummary]) -> Self {
        let count = runs.len().max(1) as f64;
        let mean = |values: Vec<f64>| {
            let sum: f64 = values.iter().sum();
            (!values.is_empty()).then(|| sum / values.len() as f64)
        };
        let followers = || runs.iter().flat_map(|run| run.robots.iter().skip(1));
        let slips = runs.iter().flat_map(|run| &run.robots);
        let slips = slips.filter_map(|robot| robot.slip_time_s).flatten();
        let links = || runs.iter().flat_map(|run| &run.links);
        let sent: u64 = links().map(|link| link.sent).sum();
        let lost: u64 = links().map(|link| link.lost).sum();
        let spacing = |run: &RunSummary| {
            let errors = run.robots.iter().skip(1);
            gain(errors.map(|robot| robot.max_spacing_error_m))
        };
        let speed = |run: &RunSummary| gain(run.robots.iter().map(|own| own.max_desired_speed_m_s));
        Self {
            set: cell.iter().cloned().collect(),
            max_desired_speed_m_s: followers()
                .filter_map(|robot| robot.max_desired_speed_m_s)
                .reduce(f64::max),
            max_spacing_error_m: followers()
                .filter_map(|robot| robot.max_spacing_error_m)
                .reduce(f64::max),
            string_gain: mean(runs.iter().filter_map(spacing).collect()),
            speed_gain: mean(runs.iter().filter_map(speed).collect()),
            slip_time_s: slips.sum::<f64>() / count,
            lost: lost as f64 / sent.max(1) as f64,
        }
    }
}

/// The largest ratio of one value to the one before it.
fn gain(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.collect::<Option<_>>()?;
    let pairs = values.windows(2).filter(|pair| pair[0] > 0.0);
    pairs.map(|pair| pair[1] / pair[0]).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_is_a_point() {
        let list = |values: &[&str]| values.iter().map(|own| (*own).to_owned()).collect();
        let keys = [
            ("a".to_owned(), list(&["1", "2"])),
            ("b".to_owned(), list(&["x", "y", "z"])),
        ];
        let cells = cells(&keys).unwrap();
        assert_eq!(cells.len(), 6);
        assert_eq!(cells[1][1].1, "y");
        assert_eq!(cells[3][0].1, "2");
    }

    #[test]
    fn a_gain_above_one_grows_along_the_platoon() {
        assert_eq!(
            gain([Some(1.0), Some(0.5), Some(1.0)].into_iter()),
            Some(2.0)
        );
        assert_eq!(gain([Some(0.0), Some(1.0)].into_iter()), None);
        assert_eq!(gain([Some(1.0), None].into_iter()), None);
    }
}
