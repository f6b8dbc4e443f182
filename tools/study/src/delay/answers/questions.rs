//! All questions that a study answers, in order.

use super::answer::StudyAnswer;
use super::disturbances::{constant, random};
use super::equations::{bound, origin, sign, which_form};
use super::followers::{gain, growth, slip};
use crate::StudyError;
use crate::delay::grid::Grid;
use crate::delay::point::Point;

/// Answers every question that the grid's points can answer.
///
/// # Errors
/// When a run that a question needs fails.
pub fn answers(
    grid: &Grid,
    points: &[Point],
    threads: usize,
) -> Result<Vec<StudyAnswer>, StudyError> {
    let mut answers = vec![which_form(points), sign(points)];
    answers.extend(origin(grid)?);
    answers.push(bound(points));
    answers.extend(constant(points));
    answers.extend(random(points, ["jitter", "Jitter"], "s", |cell| {
        cell.jitter_s
    }));
    answers.extend(random(points, ["loss", "Loss"], "share", |cell| cell.loss));
    answers.push(slip(points));
    answers.extend(gain(points));
    answers.extend(growth(grid, threads)?);
    Ok(answers)
}
