//! The table of parameters: of everything that a machine that is commanded speeds may have, what it moves,
//! how large it plausibly is, below which size it is none, and what it is reported as.

mod clocks;
mod draft;
mod drive;
mod known;
mod laws;
mod noise;
mod parameters;
mod sizes;
mod wheels;

pub(crate) use known::Asked;
pub(crate) use parameters::{Key, Table};
