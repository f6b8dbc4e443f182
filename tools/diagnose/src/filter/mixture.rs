//! Scale mixture of Gaussians: a row may be an outlier, or the robot may have jumped before it.
//!
//! Each row is ordinary, or its sensor noise is 10 or 100 times as large, or the process noise since
//! the last row is. The posterior is merged by moments after every row (GPB1; Bar-Shalom, Li and
//! Kirubarajan 2001, section 11.6.5): whether a row was bad or the robot jumped is decided by the
//! rows that follow.

/// Prior probability of each component.
pub(crate) const PROBABILITY: [f64; 5] = [0.94, 0.02, 0.01, 0.02, 0.01];
/// Factor on the variance of the sensor for each component.
pub(crate) const SENSOR: [f64; 5] = [1.0, 100.0, 1e4, 1.0, 1.0];
/// Factor on the variance of the process for each component.
pub(crate) const PROCESS: [f64; 5] = [1.0, 1.0, 1.0, 100.0, 1e4];
/// Number of components; the first is the ordinary one.
pub(crate) const COMPONENTS: usize = 5;
/// Components less probable than this share of the most probable one are left out (nats).
pub(crate) const NEGLIGIBLE_NATS: f64 = 11.0;

/// Log-likelihoods of the components, prior included, into posterior probabilities; and the
/// log-likelihood of the mixture. Components left out have `None`.
pub(crate) fn posterior<S: slipstream_sim::Scalar>(
    logs: &[Option<S>; COMPONENTS],
) -> ([S; COMPONENTS], S) {
    let best = logs
        .iter()
        .flatten()
        .map(slipstream_sim::Scalar::value)
        .fold(f64::NEG_INFINITY, f64::max);
    let zero = S::constant(0.0);
    let exponentials = logs.map(|log| log.map_or(zero, |log| (log - S::constant(best)).exp()));
    let total = exponentials.iter().fold(zero, |sum, term| sum + *term);
    (
        exponentials.map(|term| term / total),
        total.ln() + S::constant(best),
    )
}
