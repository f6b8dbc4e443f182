//! A study, or one shard of it: the grid, its points, the answers.

use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};
use slipstream_bus::Shard;

use super::answers::{StudyAnswer, answers};
use super::grid::Grid;
use super::point::Point;
use super::run_points::run_points_until;
use crate::StudyError;

/// A study of communication delay, or one shard of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// Version of this format.
    pub format: u32,
    /// The grid that was asked for.
    pub grid: Grid,
    /// Which part of the grid this is.
    pub shard: Shard,
    /// The points, in the order of the grid.
    pub points: Vec<Point>,
    /// The answers; empty for a shard or an interrupted study.
    pub answers: Vec<StudyAnswer>,
    /// Whether it was interrupted: only the points finished before are present.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub interrupted: bool,
}

/// Runs a shard of a grid on `threads` threads, and answers the questions if it is the whole study.
/// Once `stop` is set no further run begins; the study then holds the points finished so far.
///
/// # Errors
/// A grid that cannot be run, or a run that fails.
pub fn study(
    grid: &Grid,
    shard: Shard,
    threads: usize,
    stop: &AtomicBool,
) -> Result<Study, StudyError> {
    grid.validate(shard)?;
    let cells = shard.pick(grid.cells());
    let points = run_points_until(&cells, grid.runs, threads, stop)?;
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
