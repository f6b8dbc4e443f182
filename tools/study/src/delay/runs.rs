//! Many runs on all cores. Every run stands by itself and its result has its own place, so that the
//! number of threads changes nothing.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressStyle};
use slipstream_bus::Experiment;
use slipstream_launch::{RunError, in_process};

use super::Study;
use super::answers::answers;
use super::grid::{Cell, Grid, Shard};
use super::point::{Point, Run};
use super::watch::Watch;
use crate::StudyError;

/// Runs a shard of a grid; the answers come with a whole study. Once `stop` is set no point is begun
/// and none is finished any more: the study then holds what there is.
///
/// # Errors
/// A grid that cannot be run.
pub fn study(
    grid: &Grid,
    shard: Shard,
    threads: usize,
    stop: &AtomicBool,
) -> Result<Study, StudyError> {
    grid.validate(shard)?;
    let cells: Vec<Cell> = (0..)
        .zip(grid.cells())
        .filter_map(|(place, cell)| shard.has(place).then_some(cell))
        .collect();
    let points = finished(&cells, grid.runs, threads, stop)?;
    let interrupted = points.len() < cells.len();
    let answers = if shard == Shard::WHOLE && !interrupted {
        answers(grid, &points, threads)?
    } else {
        Vec::new()
    };
    Ok(Study {
        format: 1,
        grid: grid.clone(),
        shard,
        points,
        answers,
        interrupted,
    })
}

/// Runs every cell with the seeds 1 to `runs`, with a progress bar where somebody looks.
///
/// # Errors
/// The first cell, in order, that cannot be run.
pub fn points(cells: &[Cell], runs: u32, threads: usize) -> Result<Vec<Point>, StudyError> {
    finished(cells, runs, threads, &AtomicBool::new(false))
}

/// Likewise, until `stop` is set: the points that are finished then.
fn finished(
    cells: &[Cell],
    runs: u32,
    threads: usize,
    stop: &AtomicBool,
) -> Result<Vec<Point>, StudyError> {
    let experiments: Vec<Experiment> = cells
        .iter()
        .map(Cell::experiment)
        .collect::<Result<_, _>>()?;
    let bar = ProgressBar::new(cells.len() as u64 * u64::from(runs));
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left") {
        bar.set_style(style);
    }
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<Finished>>> = Mutex::new(cells.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, cells.len().max(1)) {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(cell) = cells.get(place) else {
                        return;
                    };
                    let point = point(cell, &experiments[place], runs, &bar, stop);
                    let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                    done[place] = Some(point);
                }
            });
        }
    });
    bar.finish_and_clear();
    let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    let points: Vec<Option<Point>> = done.into_iter().flatten().collect::<Result<_, _>>()?;
    Ok(points.into_iter().flatten().collect())
}

/// What became of a point; none when it was stopped before its last run.
type Finished = Result<Option<Point>, RunError>;

/// One point.
fn point(
    cell: &Cell,
    experiment: &Experiment,
    runs: u32,
    bar: &ProgressBar,
    stop: &AtomicBool,
) -> Finished {
    let mut experiment = experiment.clone();
    let mut results = Vec::new();
    for seed in 1..=runs {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        experiment.settings.seed = seed.into();
        results.push(one(&experiment)?);
        bar.inc(1);
    }
    Ok(Some(Point::new(cell, &experiment, &results)))
}

/// One run.
pub(super) fn one(experiment: &Experiment) -> Result<Run, RunError> {
    let (reports, watch) = in_process::run_recorded(experiment, false, Watch::new(experiment))?;
    Ok(Run::new(experiment, &reports, &watch))
}
