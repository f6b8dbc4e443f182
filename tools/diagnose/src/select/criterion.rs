//! The one criterion: a false-alarm rate for each recording, over everything that is looked at.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

use crate::estimate::Likelihood;

/// Probability that a recording in which nothing is to be found yields a finding.
pub(crate) const FALSE_ALARM: f64 = 0.01;

/// Hypotheses whose likelihoods differ by less cannot be told apart (nats).
pub(crate) const TIE_NATS: f64 = 4.0;
/// A look-alike has to fit better by this to take a term's place (nats).
pub(super) const BETTER_NATS: f64 = 1.0;

/// A test of one recording, among `tried` terms, with `blocks` independent pieces of data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Criterion {
    pub(crate) tried: usize,
    pub(crate) blocks: usize,
}

/// Most blocks that count.
const MOST_BLOCKS: usize = 16;

impl Criterion {
    /// A test among `tried` terms on the data of a likelihood.
    pub(crate) fn of(likelihood: &dyn Likelihood, tried: usize) -> Self {
        let clusters = likelihood.clusters().and_then(|own| own.iter().max());
        let blocks = clusters.map_or(likelihood.blocks(), |last| last + 1);
        Self {
            tried,
            blocks: blocks.min(MOST_BLOCKS),
        }
    }

    /// Gain (nats) that a term of `parameters` parameters has to bring.
    pub(crate) fn least_gain(&self, parameters: usize) -> f64 {
        let rate = FALSE_ALARM / self.tried.max(1) as f64;
        ChiSquared::new(parameters.max(1) as f64)
            .map_or(f64::INFINITY, |chi2| chi2.inverse_cdf(1.0 - rate) / 2.0)
    }

    /// Least Wald statistic d' V⁻¹ d (Hotelling's T² with the blocks as observations).
    pub(crate) fn least_wald(&self, parameters: usize) -> f64 {
        let rate = FALSE_ALARM / self.tried.max(1) as f64;
        let (k, n) = (parameters as f64, self.blocks as f64 - 1.0);
        let second = n - k + 1.0;
        if second < 1.0 {
            return f64::INFINITY;
        }
        FisherSnedecor::new(k, second).map_or(f64::INFINITY, |f| {
            f.inverse_cdf(1.0 - rate) * k * n / second
        })
    }

    /// Probability of a Wald statistic at least as large without the term, over everything tried.
    pub(crate) fn p_value(&self, wald: f64, parameters: usize) -> f64 {
        let (k, n) = (parameters as f64, self.blocks as f64 - 1.0);
        let second = n - k + 1.0;
        let one = FisherSnedecor::new(k, second.max(1.0))
            .map_or(1.0, |f| f.sf(wald * second.max(1.0) / (k * n.max(1.0))));
        (one * self.tried as f64).min(1.0)
    }

    /// The same for a single term.
    pub(crate) fn alone(&self) -> Self {
        Self { tried: 1, ..*self }
    }

    /// Half width of a 95 % interval in standard deviations.
    pub(crate) fn half_width(&self) -> f64 {
        let freedom = (self.blocks as f64 - 1.0).max(1.0);
        StudentsT::new(0.0, 1.0, freedom).map_or(1.96, |t| t.inverse_cdf(0.975))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_those_of_tables() {
        let one = Criterion {
            tried: 1,
            blocks: 16,
        };
        // chi-square with 1 degree: 6.635 at 1 %; t with 15 degrees: 2.947 at 1 %, 2.131 at 5 %
        assert!((one.least_gain(1) - 6.635 / 2.0).abs() < 1e-3);
        assert!((one.least_wald(1) - 2.947_f64.powi(2)).abs() < 1e-2);
        assert!((one.half_width() - 2.131).abs() < 1e-3);
        assert!((one.p_value(2.947_f64.powi(2), 1) - 0.01).abs() < 1e-4);
    }
}
