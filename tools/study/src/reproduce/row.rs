//! One line of the table: paper, computed, agrees, why not.

use serde::Serialize;

/// Two numbers agree when they are no further apart than this share of the printed one.
pub const TOLERANCE: f64 = 0.05;

/// One quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What, with its unit.
    pub quantity: String,
    /// Where the paper says it.
    pub source: &'static str,
    /// As printed; none where the paper makes a claim in words, or none at all.
    pub paper: Option<f64>,
    /// As it comes out; none where it does not come out.
    pub computed: Option<f64>,
    /// Within 5 % of the printed number, or as the words claim; none where the paper says nothing.
    pub agrees: Option<bool>,
    /// Why not, or what it means.
    pub note: String,
    /// The assumptions without which the number would be another.
    pub depends_on: Vec<&'static str>,
}

impl Row {
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

    /// Something that the paper claims in words.
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

    /// Something that the paper says nothing about.
    pub(super) fn found(quantity: impl Into<String>, source: &'static str, computed: f64) -> Self {
        Self {
            quantity: quantity.into(),
            source,
            paper: None,
            computed: computed.is_finite().then_some(computed),
            agrees: None,
            note: String::new(),
            depends_on: Vec::new(),
        }
    }

    /// With its reason.
    pub(super) fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// With the assumptions that it depends on.
    pub(super) fn on(mut self, assumptions: &[&'static str]) -> Self {
        self.depends_on = assumptions.to_vec();
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_per_cent_of_the_printed_number() {
        let agrees = |computed| Row::printed("q", "s", -2.0, computed).agrees;
        assert_eq!(agrees(-2.09), Some(true));
        assert_eq!(agrees(-2.11), Some(false));
        assert_eq!(agrees(2.0), Some(false));
        assert_eq!(agrees(f64::NAN), Some(false));
    }
}
