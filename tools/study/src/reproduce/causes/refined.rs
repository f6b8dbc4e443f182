//! The sizes of chosen causes, fitted to the simulation with all of them together.

use nalgebra::{DMatrix, DVector};

use super::candidate::Candidate;
use super::fit::{Chosen, Problem, TAPE_M, half_widths, step};
use super::numbers::{COUNT, Numbers};
use super::simulated::Simulation;
use crate::StudyError;

/// Steps of the fit: the sum of the responses is close already.
const STEPS: usize = 6;

/// Causes as simulated together.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    pub(super) chosen: Chosen,
    /// Half the width of the 95 % interval of each size.
    pub(super) half_widths: Vec<f64>,
    /// The numbers with all causes (m).
    pub(super) numbers: Numbers,
}

impl Refined {
    /// From the sizes of `chosen` on.
    pub(super) fn new(
        simulation: &Simulation,
        problem: &Problem<'_>,
        mut chosen: Chosen,
    ) -> Result<Self, StudyError> {
        let largest = |place: usize| problem.responses[place].candidate.kind.largest();
        let simulated = |chosen: &Chosen| {
            let own = chosen
                .iter()
                .map(|&(place, size)| (problem.responses[place].candidate, size));
            simulation.numbers(&own.collect::<Vec<(Candidate, f64)>>())
        };
        let left = |numbers: &Numbers| {
            DVector::from_fn(COUNT, |i, _| (problem.printed[i] - numbers[i]) / TAPE_M)
        };
        let mut numbers = simulated(&chosen)?;
        let mut slopes = DMatrix::zeros(COUNT, chosen.len());
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            for column in 0..chosen.len() {
                let size = 0.02 * largest(chosen[column].0);
                let mut moved = chosen.clone();
                moved[column].1 += size;
                let changed = simulated(&moved)?;
                for i in 0..COUNT {
                    slopes[(i, column)] = (changed[i] - numbers[i]) / size / TAPE_M;
                }
            }
            let before = left(&numbers);
            let Some(next) = step(&chosen, &slopes, &before, damping, largest) else {
                break;
            };
            let reached = simulated(&next)?;
            let gain = before.norm_squared() - left(&reached).norm_squared();
            if gain > 0.0 {
                (chosen, numbers, damping) = (next, reached, damping / 4.0);
            } else {
                damping *= 16.0;
            }
            if gain.abs() < 1e-2 {
                break;
            }
        }
        let widths = half_widths(&slopes, &left(&numbers));
        Ok(Self {
            half_widths: widths.unwrap_or_else(|| vec![f64::INFINITY; chosen.len()]),
            chosen,
            numbers,
        })
    }
}
