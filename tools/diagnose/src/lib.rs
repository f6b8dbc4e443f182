//! Recording and model in; what the model leaves out, where, how much and how sure, out.

mod windows;

pub use windows::{
    Against, Answer, Figures, Finding, HeldOut, HeldOutChannel, Illustrated, InputError, Limit,
    MissingForce, ParameterEstimate, Paths, Point, Prediction, Request, Residuals, Seen,
    Unexplained, Verdict, Warning, diagnose, diagnose_with_figures, in_digits, manoeuvre, predict,
};
