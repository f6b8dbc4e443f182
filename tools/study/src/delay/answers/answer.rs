//! A question and its answer, and the averages that answers are made of.

use serde::{Deserialize, Serialize};

use crate::delay::forms::Form;
use crate::delay::point::Point;

/// A question and what the runs answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The question.
    pub question: String,
    /// The answer in words.
    pub answer: String,
    /// The numbers behind it, each with its unit in its name.
    pub numbers: Vec<(String, f64)>,
}

impl Answer {
    /// An answer with the numbers behind it; a number that is not finite is left out, because JSON
    /// cannot hold it.
    pub(super) fn new(question: &str, answer: String, numbers: &[(&str, f64)]) -> Self {
        let known = numbers.iter().filter(|(_, value)| value.is_finite());
        Self {
            question: question.to_owned(),
            answer,
            numbers: known
                .map(|&(name, value)| (name.to_owned(), value))
                .collect(),
        }
    }
}

/// Points without jitter and loss, or all points if there are none.
pub(super) fn steady(points: &[Point]) -> Vec<&Point> {
    let undisturbed = |point: &&Point| point.cell.jitter_s == 0.0 && point.cell.loss == 0.0;
    let found: Vec<&Point> = points.iter().filter(undisturbed).collect();
    if found.is_empty() {
        points.iter().collect()
    } else {
        found
    }
}

/// Root mean square of a form's error over points (m/s).
pub(super) fn rms(points: &[&Point], form: Form) -> f64 {
    let squares: f64 = points.iter().map(|point| point.rms_m_s(form).powi(2)).sum();
    (squares / points.len().max(1) as f64).sqrt()
}

/// Mean of the values; NaN if there are none.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { f64::NAN }
}
