//! Intervals of numbers by which the likelihood has no derivative.

use crate::model::plant::filtered::Filtered;
use crate::model::plant::machine::Machine;

/// Upper 5 % point of chi-square with one degree of freedom.
const ONE_IN_TWENTY: f64 = 3.841;
/// A profile goes no further than this multiple of a value.
const MOST_MULTIPLE: f64 = 20.0;

impl Machine {
    /// Where −2 ln L, at the gains of `fit`, has risen by what one parameter takes with 95 %: for what
    /// has no derivative.
    pub(crate) fn profile(&self, fit: &Filtered, index: usize, name: &str) -> Option<[f64; 2]> {
        let own = &fit.hypotheses[index];
        let at = own.value(name)?;
        let here = self.deviance(&fit.whitened);
        let rises = |value: f64| {
            let mut all = fit.hypotheses.clone();
            all[index].set(name, value);
            all[index].keep_in_order();
            if all[index].value(name) != Some(value) {
                // static friction is not below kinetic friction
                return true;
            }
            self.innovations(fit, &all)
                .is_none_or(|e| self.deviance(&e) > here + ONE_IN_TWENTY)
        };
        let side = |sign: f64| {
            let mut inside = 0.0;
            let mut outside = 1e-3 * at.abs().max(1e-6);
            while !rises(at + sign * outside) {
                inside = outside;
                outside *= 2.0;
                if outside > at.abs() * MOST_MULTIPLE {
                    return at + sign * inside;
                }
            }
            for _ in 0..7 {
                let middle = 0.5 * (inside + outside);
                if rises(at + sign * middle) {
                    outside = middle;
                } else {
                    inside = middle;
                }
            }
            at + sign * outside
        };
        Some([side(-1.0), side(1.0)])
    }
}
