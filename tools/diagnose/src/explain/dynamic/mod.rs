//! Diagnosis of robots whose masses are known, by the extended Kalman filter over the plant.

pub(crate) mod answer;
pub(crate) mod channels;
mod compare;
mod condition;
pub(crate) mod drivers;
pub(crate) mod examine;
pub(crate) mod fit;
pub(crate) mod gauss_newton;
pub(crate) mod judged;
mod limits;
pub(crate) mod local;
pub(crate) mod machine;
pub(crate) mod noise_sizes;
pub(crate) mod pictures;
pub(crate) mod precision;
pub(crate) mod prediction;
pub(crate) mod screen;
pub(crate) mod selection;
pub(crate) mod threshold;
pub(crate) mod unknown;
