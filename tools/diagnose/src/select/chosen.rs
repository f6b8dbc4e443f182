//! A set of terms and its fit.

use super::elimination::Elimination;
use crate::estimate::scoring::Fit;
use crate::estimate::term::Term;

/// A set of terms and its fit.
#[derive(Debug, Clone)]
pub(crate) struct Chosen {
    pub(crate) fit: Fit,
    pub(crate) terms: Vec<Term>,
    /// Terms that were chosen, each with one that fits as well in its place.
    pub(crate) alike: Vec<[&'static str; 2]>,
}

impl Chosen {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.terms.iter().any(|term| term.name == name)
    }
}

impl Elimination<'_> {
    /// What a set is worth: its fit without what is due for its terms.
    pub(super) fn worth(&self, own: &Chosen) -> f64 {
        own.fit.objective - own.terms.iter().map(|term| self.due(term)).sum::<f64>()
    }
}
