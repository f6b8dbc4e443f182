//! The answer of a diagnosis, for whoever reads one: its parts, the sentences of findings, what to do about
//! them, and the calibration of the robot. Its JSON has a schema in `tools/cli/schemas`.

mod action;
mod answer;
mod calibration;
mod digits;
mod figures;
#[cfg(test)]
mod fixture;
mod manoeuvre;
mod miscount;
mod setup;
pub mod shape;
pub mod statement;

pub use action::advise;
pub use answer::{
    Answer, Budget, BudgetPart, Detectable, Evidence, Finding, HeldOut, HeldOutChannel, Outliers,
    ParameterEstimate, Place, ProcessNoise, Unexplained, Verdict, Warning,
};
pub use calibration::calibration;
pub use digits::in_digits;
pub use figures::{
    ErrorLine, Figures, LawCurve, Limit, MissingForce, Motion, Paths, Point, Profile, Seen,
};
pub use manoeuvre::manoeuvre;
pub use statement::change;
