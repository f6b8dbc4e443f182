//! A force outside of the catalogue beside what was found.

use super::unknown::{Beside, Unknown};
use crate::estimate::Likelihood;
use crate::estimate::scoring::Fit;
use crate::estimate::term::Term;
use crate::model::plant::likelihood::Plant;
use crate::select::elimination::Elimination;

/// Share of a gain that an effect has to keep beside a force outside of the catalogue: less may be that
/// force's as well.
const SHARE_OF_OTHERS: f64 = 0.3;
/// Multiple of what integrators differ by below which a force outside of the catalogue is none.
const SMALL: f64 = 4.0;
/// Blocks without which a force outside of the catalogue still has to gain a share of it.
const FEW_BLOCKS: usize = 2;
const SHARE_BEYOND_FEW: f64 = 0.3;

/// A search for a force beside what was selected.
pub(crate) struct Outside<'a> {
    pub(crate) selection: &'a Elimination<'a>,
    pub(crate) plant: &'a Plant<'a>,
    /// Everything that was tried.
    pub(crate) terms: &'a [Term],
}

impl Outside<'_> {
    /// A force that `fit` lacks, which loses those of its terms that are not needed beside it.
    pub(crate) fn found(&self, fit: &mut Fit, left: &mut Vec<Term>) -> Option<Unknown> {
        let mut unknown = self.beside(fit)?;
        let small = {
            let floor = self.plant.machine.floor(unknown.fit.noise.of_wheels);
            (0..2).all(|i| unknown.largest[i] < SMALL * floor[i])
        };
        let due = 2.0 * self.selection.criterion.least_gain(unknown.numbers);
        if unknown.gain < due || small || self.is_rare(fit, &unknown) {
            return None;
        }
        while let Some((less, rest, own)) = self.taken(fit, left, &unknown) {
            (*fit, *left, unknown) = (less, rest, own);
        }
        Some(unknown)
    }

    fn beside(&self, fit: &Fit) -> Option<Unknown> {
        Beside {
            machine: self.plant.machine,
            table: self.plant.table,
            at: &fit.at,
            fit: self.plant.filtered(&fit.at)?.as_ref(),
        }
        .unknown(2.0 * self.selection.criterion.least_gain(1))
    }

    /// Whether a force gains at few moments alone: rare gusts, each at a place of its own, look like a force that
    /// follows the place.
    fn is_rare(&self, fit: &Fit, unknown: &Unknown) -> bool {
        let before = self.plant.value(&fit.at);
        let mut gains: Vec<f64> = unknown
            .by_block
            .iter()
            .zip(&before)
            .map(|(a, b)| a - b)
            .collect();
        gains.sort_by(|a, b| b.total_cmp(a));
        let rest: f64 = gains.iter().skip(FEW_BLOCKS).sum();
        unknown.driver != "t" && 2.0 * rest < SHARE_BEYOND_FEW * unknown.gain
    }

    /// The fit without the term that a force takes most of, where one does; what is left, and the force beside it.
    fn taken(
        &self,
        fit: &Fit,
        left: &[Term],
        unknown: &Unknown,
    ) -> Option<(Fit, Vec<Term>, Unknown)> {
        let all = left.iter().filter_map(|term| {
            let (less, rest, _) = self.selection.removed(fit, term, left, self.terms);
            let own = self.beside(&less)?;
            let rise = own.fit.deviance - unknown.fit.deviance;
            let brought = 2.0 * (fit.objective - less.objective);
            let needed = (2.0 * self.selection.due(term)).max(SHARE_OF_OTHERS * brought);
            (rise < needed).then_some((less, rest, own))
        });
        all.min_by(|a, b| a.2.fit.deviance.total_cmp(&b.2.fit.deviance))
    }
}
