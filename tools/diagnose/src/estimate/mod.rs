//! Estimation of parameters from innovations: penalised maximum likelihood by Fisher scoring,
//! covariance by a jackknife over blocks of time.
//!
//! Nothing here knows a robot: a [`Likelihood`] is a function of a vector, summed over blocks.

pub(crate) mod blocks;
pub(crate) mod cluster;
pub(crate) mod information;
pub(crate) mod masked;
pub(crate) mod pairs;
mod raised;
pub(crate) mod scoring;
pub(crate) mod term;
pub(crate) mod whitened;

use nalgebra::{DMatrix, DVector};

/// The log-likelihood of each block (nats) as a function of parameters.
pub(crate) type Near<'a> = Box<dyn Fn(&[f64]) -> Vec<f64> + Sync + 'a>;

/// A log-likelihood that is a sum over blocks of time.
pub(crate) trait Likelihood: Sync {
    /// Number of blocks.
    fn blocks(&self) -> usize;

    /// Run to which each block belongs.
    fn run_of(&self) -> Vec<usize>;

    /// The cluster of each block, where some blocks are known to err together; `None` where each is a
    /// cluster of its own.
    fn clusters(&self) -> Option<&[usize]> {
        None
    }

    /// Share of the variance of innovations that two recordings of one course do not have in common; 1
    /// where no such recordings are compared.
    fn apart(&self, _at: &[f64]) -> f64 {
        1.0
    }

    /// Puts what two recordings have in common back to where a search begins: near 1 the likelihood knows no
    /// way from one hypothesis to another.
    fn loosen(&self, _at: &mut [f64]) {}

    /// Whether a parameter is shared by all runs.
    fn is_shared(&self, parameter: usize) -> bool;

    /// Log-likelihood of each block (nats).
    fn value(&self, at: &[f64]) -> Vec<f64>;

    /// The log-likelihood of each block (nats) near `at`, as far as a look at many parameters needs it: what costs
    /// much may stay as it is at `at`.
    fn near<'a>(&'a self, _at: &[f64]) -> Near<'a> {
        Box::new(|other| self.value(other))
    }

    /// Where fits of a term begin that is searched by [`term::Search::Located`], beside `at`; `rival` is the best fit
    /// with another term.
    fn located(&self, _term: &term::Term, _at: &[f64], _rival: &[f64]) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// `at` with the parameters of a located term moved to where they fit better, where derivatives do not tell.
    fn refined(&self, _term: &term::Term, _at: &[f64]) -> Option<Vec<f64>> {
        None
    }

    /// Score and Fisher information of each block with regard to the parameters `free`.
    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore>;
}

/// Derivatives of the log-likelihood of one block.
#[derive(Debug, Clone)]
pub(crate) struct BlockScore {
    pub(crate) gradient: DVector<f64>,
    pub(crate) information: DMatrix<f64>,
}

/// What is known of a parameter before the data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prior {
    pub(crate) mean: f64,
    pub(crate) deviation: f64,
    /// Whether it is a Cauchy distribution, with `deviation` as its scale: most values are small, and some are
    /// anything. Else it is normal.
    pub(crate) has_tails: bool,
}

/// How far values with tails go, in scales: one in sixteen lies beyond.
const TAIL: f64 = 10.0;

impl Prior {
    /// Log-density up to a constant (nats).
    pub(crate) fn log(&self, value: f64) -> f64 {
        let z = (value - self.mean) / self.deviation;
        if self.has_tails {
            return -(z * z).ln_1p();
        }
        -0.5 * z * z
    }

    /// Precision of the normal distribution that has the same derivative at a value.
    pub(crate) fn precision(&self, value: f64) -> f64 {
        let z = (value - self.mean) / self.deviation;
        let share = if self.has_tails {
            2.0 / (1.0 + z * z)
        } else {
            1.0
        };
        share / (self.deviation * self.deviation)
    }

    /// How far values go.
    pub(crate) fn reach(&self) -> f64 {
        if self.has_tails {
            TAIL * self.deviation
        } else {
            self.deviation
        }
    }
}
