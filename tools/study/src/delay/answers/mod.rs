//! Answers in words. Every number in them is computed from the points of the study or from the few
//! extra runs that a question needs.

mod answer;
mod disturbances;
mod equations;
mod followers;
mod questions;

pub use answer::{StudyAnswer, Table};
pub use questions::answers;
