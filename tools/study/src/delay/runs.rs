//! Many runs on all cores. Every run stands by itself and its result has its own place, so that the
//! number of threads changes nothing.

use std::sync::atomic::{AtomicUsize, Ordering};
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

/// Runs a shard of a grid; the answers come with a whole study.
///
/// # Errors
/// A grid that cannot be run.
pub fn study(grid: &Grid, shard: Shard, threads: usize) -> Result<Study, StudyError> {
    grid.validate(shard)?;
    let cells: Vec<Cell> = (0..)
        .zip(grid.cells())
        .filter_map(|(place, cell)| shard.has(place).then_some(cell))
        .collect();
    let points = points(&cells, grid.runs, threads)?;
    let answers = if shard == Shard::WHOLE {
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
    })
}

/// Runs every cell with the seeds 1 to `runs`, with a progress bar where somebody looks.
///
/// # Errors
/// The first cell, in order, that cannot be run.
pub fn points(cells: &[Cell], runs: u32, threads: usize) -> Result<Vec<Point>, StudyError> {
    let experiments: Vec<Experiment> = cells
        .iter()
        .map(Cell::experiment)
        .collect::<Result<_, _>>()?;
    let bar = ProgressBar::new(cells.len() as u64 * u64::from(runs));
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left") {
        bar.set_style(style);
    }
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<Result<Point, RunError>>>> =
        Mutex::new(cells.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, cells.len().max(1)) {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(cell) = cells.get(place) else {
                        return;
                    };
                    let point = point(cell, &experiments[place], runs, &bar);
                    let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
                    done[place] = Some(point);
                }
            });
        }
    });
    bar.finish_and_clear();
    let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(done.into_iter().flatten().collect::<Result<_, _>>()?)
}

fn point(
    cell: &Cell,
    experiment: &Experiment,
    runs: u32,
    bar: &ProgressBar,
) -> Result<Point, RunError> {
    let mut experiment = experiment.clone();
    let mut results = Vec::new();
    for seed in 1..=runs {
        experiment.settings.seed = seed.into();
        results.push(one(&experiment)?);
        bar.inc(1);
    }
    Ok(Point::new(cell, &experiment, &results))
}

/// One run.
pub(super) fn one(experiment: &Experiment) -> Result<Run, RunError> {
    let (reports, watch) = in_process::run_recorded(experiment, false, Watch::new(experiment))?;
    Ok(Run::new(experiment, &reports, &watch))
}
