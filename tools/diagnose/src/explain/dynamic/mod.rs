//! Diagnosis of robots whose masses are known, by the extended Kalman filter over the plant.

pub(crate) mod answer;
pub(crate) mod baseline;
mod compare;
mod condition;
pub(crate) mod drivers;
pub(crate) mod examine;
pub(crate) mod judged;
mod limits;
mod outside;
pub(crate) mod pictures;
pub(crate) mod prediction;
pub(crate) mod profile;
pub(crate) mod selection;
pub(crate) mod unknown;
