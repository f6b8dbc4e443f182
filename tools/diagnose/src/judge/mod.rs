//! The judge: what predictions over 5 s are worth, on blocks of time that no fit has seen, beside the error
//! that the sensors' noise and the reported process noise predict.
//!
//! It is given sums of errors, and knows nothing of how a model was found.

mod adequacy;
mod budget;
mod passing;
mod predictions;
mod score;
mod starts;
mod worse;

pub(crate) use adequacy::conclude;
pub(crate) use passing::{Culprit, passing};
pub(crate) use predictions::{Predictions, Worth};
pub(crate) use score::{GYRO, HEADING, PLACE, POSE, QUANTITIES, Score, name};
