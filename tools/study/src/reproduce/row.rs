//! One row of the comparison: paper, computed, whether they agree, and why not.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::quantity;

/// Largest relative difference from the printed number at which two numbers agree.
pub const TOLERANCE: f64 = 0.05;

/// One quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PaperRow {
    /// Name of the quantity, with its unit.
    pub quantity: String,
    /// The same for people.
    pub name: String,
    /// Where in the paper.
    pub source: Cow<'static, str>,
    /// The printed number; null if the paper makes a claim in words or says nothing.
    pub paper: Option<f64>,
    /// The computed number; null if there is none.
    pub computed: Option<f64>,
    /// Whether the number is within 5 % of the printed one, or the claim holds; null if the paper says
    /// nothing.
    pub agrees: Option<bool>,
    /// Why it does not agree, or what it means.
    pub note: String,
    /// Names of the assumptions that change the number.
    pub depends_on: Vec<Cow<'static, str>>,
}

impl PaperRow {
    /// A number that the paper prints.
    pub(super) fn printed(
        quantity: impl Into<String>,
        source: &'static str,
        paper: f64,
        computed: f64,
    ) -> Self {
        let agrees = (computed - paper).abs() <= TOLERANCE * paper.abs();
        Self {
            paper: Some(paper),
            agrees: Some(agrees),
            ..Self::found(quantity, source, computed)
        }
    }

    /// A claim that the paper makes in words.
    pub(super) fn claim(
        quantity: impl Into<String>,
        source: &'static str,
        computed: f64,
        holds: bool,
    ) -> Self {
        Self {
            agrees: Some(holds),
            ..Self::found(quantity, source, computed)
        }
    }

    /// A number that the paper says nothing about.
    pub(super) fn found(quantity: impl Into<String>, source: &'static str, computed: f64) -> Self {
        let quantity = quantity.into();
        Self {
            name: quantity::name(&quantity),
            quantity,
            source: source.into(),
            paper: None,
            computed: computed.is_finite().then_some(computed),
            agrees: None,
            note: String::new(),
            depends_on: Vec::new(),
        }
    }

    /// Adds the note.
    pub(super) fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// Adds the assumptions that change the number.
    pub(super) fn depending_on(mut self, assumptions: &[&'static str]) -> Self {
        self.depends_on = assumptions.iter().map(|&name| name.into()).collect();
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_agree_within_five_per_cent() {
        let agrees = |computed| PaperRow::printed("q", "s", -2.0, computed).agrees;
        assert_eq!(agrees(-2.09), Some(true));
        assert_eq!(agrees(-2.11), Some(false));
        assert_eq!(agrees(2.0), Some(false));
        assert_eq!(agrees(f64::NAN), Some(false));
    }
}
