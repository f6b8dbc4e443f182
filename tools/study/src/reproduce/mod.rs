//! The paper's experiments run again: every printed number beside the computed one.

mod assumptions;
mod causes;
mod comparison;
mod extensions;
mod limits;
mod paper_runs;
mod platoon;
mod printed;
mod quantity;
mod recorded_run;
mod row;
mod single;

pub use assumptions::{Assumption, assumptions};
pub use causes::{Cause, Explanation, FinalPosition, HeldOut};
pub use comparison::{Comparison, Reproduction, reproduce};
pub use extensions::Extension;
pub use paper_runs::PaperRuns;
pub use recorded_run::RecordedRun;
pub use row::{PaperRow, TOLERANCE};
