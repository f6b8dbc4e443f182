//! How much a selection tries.

use crate::estimate::scoring::{FULL, SHORT, SearchLimits};

/// How much a selection tries.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    /// Candidates that are refitted with noise sizes, and of these the ones that are fitted to the end.
    pub(crate) refitted: usize,
    pub(crate) converged: usize,
    /// Share of what the best candidate promises below which another one is not refitted.
    pub(crate) least_promise: f64,
    /// Whether a candidate is refitted also from less noise than was fitted without it.
    pub(crate) from_less: bool,
    /// A fit that has converged.
    pub(crate) full: SearchLimits,
    /// A fit that ranks candidates.
    pub(crate) ranked: SearchLimits,
    /// A fit that tells whether a look-alike may take the place of a term.
    pub(crate) look_alike: SearchLimits,
}

impl Effort {
    /// For a likelihood with exact derivatives.
    pub(crate) const WIDE: Self = Self {
        refitted: 6,
        converged: 3,
        least_promise: 0.0,
        from_less: true,
        full: FULL,
        ranked: RANKED,
        look_alike: SHORT,
    };
    /// For a likelihood whose derivatives are simulations.
    pub(crate) const NARROW: Self = Self {
        refitted: 4,
        converged: 2,
        least_promise: 0.1,
        from_less: false,
        full: SearchLimits {
            iterations: 40,
            tolerance_nats: 0.2,
        },
        ranked: RANKED,
        look_alike: RANKED,
    };
}

/// A fit of a few steps.
const RANKED: SearchLimits = SearchLimits {
    iterations: 3,
    tolerance_nats: 1.0,
};
