//! The arguments of `slipstream trial`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use slipstream_trial::maker::{Plan, PlannedCase};

use crate::exit::Error;
use crate::reading::Reading;

/// Number of cases of a plan that draws them, where none is given.
const DRAWN_CASES: usize = 20;

/// Score the diagnosis in a blind test, on recordings with known effects
///
/// Cases are drawn from the seed and simulated by a second simulator that shares no code with the
/// plant. Before anything is diagnosed, the recordings and a commitment to every label (SHA-256) are
/// written. Each case is diagnosed in its own process, which gets only the recording and the nominal
/// model. Then the labels are opened and checked against the commitments, and the answers are scored.
///
/// With --on, known changes are put into copies of a recording of your own, and none into others; each copy
/// is diagnosed against the original. It shows what would be found on your robot, down to which size.
///
/// Example: slipstream trial --cases 200 --seed 1 --json trial.json --out trial
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(super) part: Option<Part>,
    /// Number of cases [default: 20, or all of a plan that is a list]
    #[arg(long, value_name = "N", conflicts_with = "labels")]
    pub(super) cases: Option<usize>,
    /// Seed of all random numbers
    #[arg(long, value_name = "S", default_value_t = 1, conflicts_with = "labels")]
    pub(super) seed: u64,
    /// How the cases are chosen
    #[arg(long, value_enum, default_value_t = PlanKind::Sealed, conflicts_with = "labels")]
    pub(super) plan: PlanKind,
    /// Only cases with this effect
    #[arg(long, value_name = "EFFECT", conflicts_with = "labels")]
    pub(super) effect: Option<String>,
    /// Write recordings, models and labels, but diagnose nothing
    #[arg(long, requires = "out", conflicts_with_all = ["labels", "json", "report"])]
    pub(super) make_only: bool,
    /// New folder for the recordings, commitments and, at the end, labels [default: a temporary one]
    #[arg(long, value_name = "FOLDER", conflicts_with = "labels")]
    pub(super) out: Option<PathBuf>,
    /// Put changes into copies of this recording instead, and diagnose them against it
    #[arg(long, value_name = "RECORDING", conflicts_with_all = ["cases", "seed", "plan", "effect", "make_only", "labels", "shard", "dry_run", "resume"])]
    pub(super) on: Option<PathBuf>,
    /// Let the changes begin while the robot drives, and watch it: when is each raised, as what, since when, how large
    #[arg(long, requires = "on", conflicts_with_all = ["out", "report", "with"])]
    pub(super) watch: bool,
    /// With --watch, a recording of the same robot that is the baseline; may be repeated [default: the first half]
    #[arg(long, value_name = "OTHER", num_args = 1.., requires = "watch")]
    pub(super) against: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) reading: Reading,
    /// Robot model of that recording: robot.toml, URDF or controller YAML [default: the one in the recording]
    #[arg(long, value_name = "[NAME=]FILE", requires = "on")]
    pub(super) robot: Vec<String>,
    /// Score existing recordings instead: their labels, in the folder of the recordings
    #[arg(long, value_name = "FILE.toml")]
    pub(super) labels: Option<PathBuf>,
    /// Only these cases of the labels, separated by commas
    #[arg(long, value_name = "CASE", value_delimiter = ',', requires = "labels")]
    pub(super) only: Vec<String>,
    /// Leave an effect out of the catalogue of every diagnosis; may be repeated
    #[arg(long, value_name = "EFFECT")]
    pub(super) without: Vec<String>,
    /// Score another program, called as PROGRAM diagnose … [default: slipstream]
    #[arg(long, value_name = "PROGRAM")]
    pub(super) with: Option<PathBuf>,
    /// Time limit of one diagnosis (s)
    #[arg(long, value_name = "S", default_value_t = 300)]
    pub(super) limit_s: u64,
    /// Make and diagnose only part I of N of the cases, for the array jobs of a cluster
    #[arg(long, value_name = "I/N")]
    pub(super) shard: Option<String>,
    /// Diagnose nothing if the JSON file holds the scores of the same cases of the same trial already
    #[arg(long, requires = "json")]
    pub(super) resume: bool,
    /// Make and diagnose a few of the cases, print core hours and a number of shards, and write nothing
    #[arg(long, conflicts_with = "make_only")]
    pub(super) dry_run: bool,
    #[command(flatten)]
    pub(super) output: Output,
}

#[derive(Debug, Args)]
pub(super) struct Output {
    /// Write the scores as JSON
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write a page with the scores
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
pub(super) enum Part {
    /// Merge the shards of one trial
    ///
    /// Example: slipstream trial merge shard-*.json --report trial.html
    Merge(Merge),
}

#[derive(Debug, Args)]
pub(super) struct Merge {
    /// The N files that `trial --shard I/N --json FILE` wrote
    #[arg(required = true)]
    pub(super) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) output: Output,
}

/// How the cases of a trial are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum PlanKind {
    /// Cases drawn at random from the seed
    Sealed,
    /// Logs of robots told speeds, or of wheels and a reference alone, drawn at random with what real logs have:
    /// late, held and lost rows, counters that wrap, references that jump, robots that skid
    Logs,
    /// A list: every effect at three sizes, pairs of effects, no effect, and physics outside the vocabulary
    Battery,
    /// A list: robots without known masses, under commanded speeds
    Kinematic,
    /// A list: process noise, with no effect, single effects and pairs
    Noise,
    /// A list: recordings that start inside what acts
    Starts,
}

impl Arguments {
    /// The program that diagnoses.
    pub(super) fn program(&self) -> Result<PathBuf, Error> {
        let program = match &self.with {
            // The diagnosis runs in another folder.
            Some(program) => std::path::absolute(program),
            None => std::env::current_exe(),
        };
        program.map_err(|error| {
            Error::Failed(format!(
                "failed to find the program that diagnoses: {error}"
            ))
        })
    }
}

impl PlanKind {
    /// The cases, in their order.
    pub(super) fn cases(
        self,
        cases: Option<usize>,
        seed: u64,
        effect: Option<&str>,
    ) -> Vec<PlannedCase> {
        let drawn = cases.unwrap_or(DRAWN_CASES);
        let plan = match self {
            Self::Sealed => Plan::sealed(drawn, seed),
            Self::Logs => Plan::logs(drawn, seed),
            Self::Battery => Plan::battery(seed),
            Self::Kinematic => Plan::kinematic(seed),
            Self::Noise => Plan::noise(seed),
            Self::Starts => Plan::starts(seed),
        };
        let plan = match effect {
            Some(id) => plan.with_effect(id),
            None => plan,
        };
        let is_drawn = matches!(self, Self::Sealed | Self::Logs);
        match cases.filter(|_| !is_drawn) {
            Some(count) => plan.spread(count),
            None => plan,
        }
        .cases()
        .collect()
    }
}
