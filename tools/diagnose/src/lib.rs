//! Recording and model in; what the model leaves out, where, how much and how sure, out.

mod answer;
mod data;
mod diagnosis;
mod estimate;
mod explain;
mod filter;
mod judge;
mod model;
mod predict;
mod select;

pub use answer::{
    Answer, Budget, BudgetPart, Detectable, ErrorLine, Evidence, Figures, Finding, HeldOut,
    HeldOutChannel, LawCurve, Limit, MissingForce, Motion, Outliers, ParameterEstimate, Paths,
    Place, Point, ProcessNoise, Profile, Seen, Unexplained, Verdict, Warning, calibration, change,
    in_digits, manoeuvre,
};
pub use diagnosis::{Illustrated, Request, diagnose, diagnose_with_figures};
pub use predict::prediction::{Prediction, predict};
/// Why a recording cannot be diagnosed.
pub use slipstream_bus::InputError;
