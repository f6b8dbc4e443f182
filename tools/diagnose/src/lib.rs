//! Recording and model in; what the model leaves out, where, how much and how sure, out.

mod data;
mod diagnosis;
mod estimate;
mod explain;
mod filter;
mod judge;
mod model;
mod predict;
mod request;
mod select;
mod watch;

use slipstream_answer as answer;

pub use diagnosis::{Illustrated, diagnose, diagnose_with_figures};
pub use predict::prediction::{Prediction, predict};
pub use request::Request;
/// What a diagnosis says.
pub use slipstream_answer::Answer;
/// Why a recording cannot be diagnosed.
pub use slipstream_bus::InputError;
pub use watch::{Change, Event, Question, Smallest, State, Watch};
