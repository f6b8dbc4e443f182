//! Diagnosis of robots whose masses are known, by the extended Kalman filter over the plant.

pub(crate) mod channels;
pub(crate) mod fit;
pub(crate) mod gauss_newton;
pub(crate) mod machine;
pub(crate) mod noise_sizes;
pub(crate) mod precision;
pub(crate) mod screen;
pub(crate) mod selection;
