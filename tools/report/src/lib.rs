//! Pages: the answers of slipstream as HTML files that need no other file and no network.
//!
//! Every page is made of [`parts`]. The words for effects stand in [`effect_words`].

pub mod compare;
pub mod diagnose;
pub mod effect_words;
pub mod parts;
pub mod reproduce;
pub mod run;
mod stages;
pub mod study;
pub mod trace;
pub mod trial;
pub mod two_runs;
