//! Runs the points of a grid in parallel. Every run is independent and every result has its own slot,
//! so that the number of threads does not change the results.

use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};
use slipstream_bus::Experiment;
use slipstream_launch::{RunError, in_process};

use super::follower_recorder::FollowerRecorder;
use super::grid::GridCell;
use super::point::{Point, RunResult};
use crate::StudyError;

/// Runs every cell with the seeds 1 to `runs` on `threads` threads, with a progress bar on a terminal.
///
/// # Errors
/// The error of the first cell, in order, that cannot be run.
pub fn run_points(cells: &[GridCell], runs: u32, threads: usize) -> Result<Vec<Point>, StudyError> {
    run_points_until(cells, runs, threads, &AtomicBool::new(false))
}

/// The same until `stop` is set; returns the points finished by then.
pub(super) fn run_points_until(
    cells: &[GridCell],
    runs: u32,
    threads: usize,
    stop: &AtomicBool,
) -> Result<Vec<Point>, StudyError> {
    let experiments: Vec<Experiment> = cells
        .iter()
        .map(GridCell::experiment)
        .collect::<Result<_, _>>()?;
    let bar = ProgressBar::new(cells.len() as u64 * u64::from(runs));
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left") {
        bar.set_style(style);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.clamp(1, cells.len().max(1)))
        .build()?;
    let mut results: Vec<PointResult> = cells.iter().map(|_| Ok(None)).collect();
    // First in, first out: an interrupted study holds the first points of the grid.
    pool.scope_fifo(|scope| {
        for ((cell, experiment), result) in cells.iter().zip(experiments).zip(&mut results) {
            let bar = &bar;
            scope.spawn_fifo(move |_| *result = run_point(cell, experiment, runs, bar, stop));
        }
    });
    bar.finish_and_clear();
    let points: Vec<Option<Point>> = results.into_iter().collect::<Result<_, _>>()?;
    Ok(points.into_iter().flatten().collect())
}

/// A point; `None` if it was stopped before its last run.
type PointResult = Result<Option<Point>, RunError>;

fn run_point(
    cell: &GridCell,
    mut experiment: Experiment,
    runs: u32,
    bar: &ProgressBar,
    stop: &AtomicBool,
) -> PointResult {
    let mut results = Vec::new();
    for seed in 1..=runs {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        experiment.settings.seed = seed.into();
        results.push(run_once(&experiment)?);
        bar.inc(1);
    }
    Ok(Some(Point::new(cell, &experiment, &results)))
}

/// Runs an experiment once.
pub(super) fn run_once(experiment: &Experiment) -> Result<RunResult, RunError> {
    let recorder = FollowerRecorder::new(experiment);
    let (reports, recorder) = in_process::run_recorded(experiment, false, recorder)?;
    Ok(RunResult::new(experiment, &reports, &recorder))
}
