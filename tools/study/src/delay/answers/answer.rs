//! A question and its answer, and the averages that answers are made of.

use serde::{Deserialize, Serialize};

use crate::delay::forms::Form;
use crate::delay::point::Point;

/// A question and what the runs answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StudyAnswer {
    /// The question.
    pub question: String,
    /// The answer in words.
    pub answer: String,
    /// A table that belongs to it, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<Table>,
    /// The numbers behind it, each with its unit in its name.
    pub numbers: Vec<(String, f64)>,
}

/// A table of an answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Heads of the columns, with units.
    pub heads: Vec<String>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
}

impl StudyAnswer {
    /// An answer with the numbers behind it; a number that is not finite is left out, because JSON
    /// cannot hold it.
    pub(super) fn new(question: &str, answer: String, numbers: &[(&str, f64)]) -> Self {
        let known = numbers.iter().filter(|(_, value)| value.is_finite());
        Self {
            question: question.to_owned(),
            answer,
            table: None,
            numbers: known
                .map(|&(name, value)| (name.to_owned(), value))
                .collect(),
        }
    }

    /// With a table.
    pub(super) fn with_table<const N: usize>(
        self,
        heads: [&str; N],
        rows: Vec<[String; N]>,
    ) -> Self {
        let table = Table {
            heads: heads.map(str::to_owned).to_vec(),
            rows: rows.into_iter().map(|row| row.to_vec()).collect(),
        };
        Self {
            table: Some(table),
            ..self
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
