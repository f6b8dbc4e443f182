//! Merges shards into the file of the whole study, as if one machine had run it.

use slipstream_bus::{InputError, Shard};

use super::answers::answers;
use super::grid::GridCell;
use super::point::Point;
use super::study::Study;
use crate::StudyError;

/// Merges all shards of one study, given with their names, and answers its questions.
///
/// # Errors
/// Shards of different studies; a shard or a point that is missing; a shard given twice.
pub fn merge(shards: &[(String, Study)], threads: usize) -> Result<Study, StudyError> {
    let parts = Shard::in_order(
        shards,
        "study",
        |study| study.shard,
        |one, other| one.grid == other.grid,
    )?;
    let grid = &parts[0].grid;
    grid.validate(parts[0].shard)?;
    let points = (0..)
        .zip(grid.cells())
        .map(|(index, cell)| point(&parts, index, &cell))
        .collect::<Result<Vec<Point>, InputError>>()?;
    Ok(Study {
        format: 1,
        grid: grid.clone(),
        shard: Shard::WHOLE,
        answers: answers(grid, &points, threads)?,
        points,
        interrupted: false,
    })
}

/// Finds the point of a cell in its shard; `index` is that of the cell in the grid.
fn point(parts: &[&Study], index: usize, cell: &GridCell) -> Result<Point, InputError> {
    let part = parts[index % parts.len()];
    let found = part.points.iter().find(|point| point.cell == *cell);
    found.cloned().ok_or_else(|| {
        let problem = match part.interrupted {
            true => "was interrupted: some points are missing",
            false => "lacks a point",
        };
        InputError::new(format!("shard {}", part.shard), problem, "run it again")
    })
}
