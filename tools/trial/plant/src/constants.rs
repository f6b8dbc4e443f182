//! Constants of nature, as the paper has them.

/// Gravitational acceleration (m/s²).
pub const GRAVITY_M_S2: f64 = 9.81;
