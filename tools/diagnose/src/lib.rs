//! Recording and model in; what the model leaves out, where, how much and how sure, out.

#[cfg_attr(not(test), allow(dead_code, reason = "the new engine, not in use yet"))]
mod data;
#[cfg_attr(not(test), allow(dead_code, reason = "the new engine, not in use yet"))]
mod estimate;
#[cfg_attr(not(test), allow(dead_code, reason = "the new engine, not in use yet"))]
mod explain;
#[cfg_attr(not(test), allow(dead_code, reason = "the new engine, not in use yet"))]
mod filter;
#[cfg_attr(not(test), allow(dead_code, reason = "the new engine, not in use yet"))]
mod model;
#[cfg_attr(not(test), allow(dead_code, reason = "the new engine, not in use yet"))]
mod select;
mod windows;

pub use windows::{
    Against, Answer, Figures, Finding, HeldOut, HeldOutChannel, Illustrated, InputError, Limit,
    MissingForce, ParameterEstimate, Paths, Point, Prediction, Request, Residuals, Seen,
    Unexplained, Verdict, Warning, diagnose, diagnose_with_figures, in_digits, manoeuvre, predict,
};
