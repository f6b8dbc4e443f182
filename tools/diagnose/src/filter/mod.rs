//! Filters: likelihood of one stream of measurements under one model (Kalman filter innovations).
//!
//! A filter knows one model and one series of data. It reports every row that it predicts as an
//! [`Innovation`]; sums, derivatives and searches are made in `estimate`. Filters are generic over
//! the scalar: with dual numbers an innovation carries its derivatives.

pub(crate) mod arc;
pub(crate) mod cholesky;
pub(crate) mod dynamic;
pub(crate) mod gyro;
pub(crate) mod mixture;
pub(crate) mod motion_law;
pub(crate) mod ornstein_uhlenbeck;
mod row_update;
pub(crate) mod wheel_channel;
pub(crate) mod wheels_to_pose;

use slipstream_sim::Scalar;

/// Rows of a symmetric 3 by 3 matrix.
pub(crate) type Matrix3<S> = [[S; 3]; 3];

/// One predicted row of measurements.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Innovation<S> {
    /// Stamp of the row (s).
    pub(crate) time_s: f64,
    /// Weight of its log-likelihood in the composite likelihood.
    pub(crate) weight: f64,
    /// Probability that the row is an ordinary one, neither an outlier nor a jump.
    pub(crate) ordinary: f64,
    /// Log-likelihood of the row given the rows before it (nats).
    pub(crate) log_likelihood: S,
    /// Whether it is a single number: the first of `difference`.
    pub(crate) scalar: bool,
    /// Measured minus predicted; 0 where nothing was measured.
    pub(crate) difference: [S; 3],
    /// Covariance of `difference` if the row is an ordinary one.
    pub(crate) covariance: Matrix3<S>,
}

impl<S: Scalar> Innovation<S> {
    /// The same without derivatives.
    pub(crate) fn values(&self) -> Innovation<f64> {
        Innovation {
            time_s: self.time_s,
            weight: self.weight,
            ordinary: self.ordinary,
            log_likelihood: self.log_likelihood.value(),
            scalar: self.scalar,
            difference: self.difference.map(|own| own.value()),
            covariance: self.covariance.map(|line| line.map(|own| own.value())),
        }
    }
}

/// A whole turn is taken off an angle until it lies within half a turn of zero.
pub(crate) fn wrapped<S: Scalar>(angle: S) -> S {
    let turns = (angle.value() / std::f64::consts::TAU).round();
    angle - S::constant(turns * std::f64::consts::TAU)
}
