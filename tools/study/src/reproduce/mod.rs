//! The paper's experiments run again, and every number that it prints beside what comes out.

mod asymmetry;
mod beyond;
mod limits;
mod platoon;
mod printed;
mod report;
mod row;
mod single;
mod trial;

pub use beyond::Beyond;
pub use report::page;
pub use row::{Row, TOLERANCE};
pub use trial::Trial;

use serde::Serialize;

use crate::StudyError;

/// Something that the paper leaves open, what is taken for it, and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Assumption {
    /// Its name, as rows refer to it.
    pub name: &'static str,
    /// What is taken, and why.
    pub text: &'static str,
}

/// All that the paper leaves open. The values themselves stand in the built-in experiments
/// (`slipstream run platoon --dry-run`).
pub const ASSUMPTIONS: [Assumption; 6] = [
    Assumption {
        name: "profile",
        text: "Fig. 8 has no numbers: 0.2 m/s until 5 s, 0.68 m/s from 5.2 s to 8 s, down to rest at \
               12 s. Chosen from the text (faster from about 5 s, slower after 8 s, standing after \
               12 s, softer in deceleration) and from about 4.3 m of way; the steepness at 5 s is \
               beyond what the floor carries, as slip is what the experiment is about.",
    },
    Assumption {
        name: "gains",
        text: "No gain is printed. k_x 1 1/s: a time constant of 20 outer ticks. k_y 15 1/m², k_θ 6 \
               1/m: a damped lateral motion by Kanayama's rule. k_p 0.04 N m s/rad, k_i 0.16 N m/rad: \
               wheels that follow within a few inner ticks.",
    },
    Assumption {
        name: "motor",
        text: "Torque is applied as commanded, up to 0.13 N m (section 3 calls that the maximum); no \
               back-EMF, although 350 1/min without load is printed.",
    },
    Assumption {
        name: "friction",
        text: "The floor has μ_s = 0.241 and μ_k = 0.239 as measured; the controller's limit uses 0.24.",
    },
    Assumption {
        name: "symmetry",
        text: "Both wheels, motors and sides of the floor are alike and every robot starts exactly \
               where and how it believes: the paper says nothing else. Lateral errors are then zero; \
               the rows `asymmetry_…` say what it would take.",
    },
    Assumption {
        name: "limit",
        text: "In the platoon the limit acts in the outer loop, as in the paper's sample; in the \
               single run, which has no loops, on the torque itself. N in Eq. 11 comes from Eq. 4 \
               to 6.",
    },
];

/// Everything that came out.
#[derive(Debug, Clone, Serialize)]
pub struct Reproduction {
    format: u32,
    /// What the paper leaves open.
    pub assumptions: Vec<Assumption>,
    /// Paper against computed.
    pub rows: Vec<Row>,
    /// Beyond the paper: turning, and a floor that changes, under every torque limit.
    pub beyond: Vec<Beyond>,
    /// The runs behind them: single and platoon, each without and with the limit.
    #[serde(skip)]
    pub trials: Trials,
}

/// The runs: [without, with] the limit.
#[derive(Debug, Clone)]
pub struct Trials {
    /// Section 3.
    pub single: [Trial; 2],
    /// Section 4.
    pub platoon: [Trial; 2],
}

/// Runs everything.
///
/// # Errors
/// When a run fails.
pub fn reproduce() -> Result<Reproduction, StudyError> {
    let trials = Trials {
        single: [
            Trial::new("single", "none")?,
            Trial::new("single", "inner")?,
        ],
        platoon: [
            Trial::new("platoon", "none")?,
            Trial::new("platoon", "outer")?,
        ],
    };
    let mut rows = limits::rows(&trials.single[0].experiment)?;
    rows.extend(single::rows(&trials.single));
    rows.extend(platoon::rows(&trials.platoon));
    rows.extend(asymmetry::rows()?);
    Ok(Reproduction {
        format: 1,
        assumptions: ASSUMPTIONS.to_vec(),
        rows,
        beyond: beyond::table()?,
        trials,
    })
}
