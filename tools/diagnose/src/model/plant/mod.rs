//! A robot whose masses are known, as a likelihood of the catalogue's effects and of its noise.

pub(crate) mod channels;
pub(crate) mod filtered;
pub(crate) mod likelihood;
pub(crate) mod located;
pub(crate) mod machine;
pub(crate) mod noise;
mod number;
mod patches;
pub(crate) mod table;
