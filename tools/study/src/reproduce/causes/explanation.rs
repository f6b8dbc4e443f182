//! The explanation as plain data.

use serde::{Deserialize, Serialize};

use super::fit::TAPE_M;

/// What explains the final positions that the paper prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// The answer in one sentence.
    pub sentence: String,
    /// What the causes do not explain, in words; empty if they explain all.
    pub remains: String,
    /// Accuracy of the tape and of printing (m).
    pub tape_m: f64,
    /// The causes, the most important first.
    pub causes: Vec<Cause>,
    /// What the paper prints, before and after.
    pub numbers: Vec<FinalPosition>,
    /// Root mean square of what is left of all numbers without any cause (m).
    pub before_m: f64,
    /// The same with all causes (m).
    pub after_m: f64,
    /// The same without an experiment or a robot at a time.
    pub held_out: Vec<HeldOut>,
}

/// A cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Its name.
    pub cause: String,
    /// The robot; null: all.
    pub robot: Option<String>,
    /// `without_limit` or `with_limit`; null: both.
    pub experiment: Option<String>,
    /// In one sentence.
    pub sentence: String,
    /// Its size.
    pub estimate: f64,
    /// 95 % interval of the size.
    pub ci95: [f64; 2],
    /// Unit of the size.
    pub unit: String,
    /// Root mean square of what is left of all numbers if it alone is left out and the others are fitted anew (m).
    pub without_it_m: f64,
    /// Other causes that explain as much in its place, in words.
    pub rivals: Vec<String>,
    /// What it changes of each of `numbers` by itself (m).
    pub changes_m: Vec<f64>,
}

/// A final coordinate that the paper prints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FinalPosition {
    /// `without_limit` or `with_limit`.
    pub experiment: String,
    /// The robot.
    pub robot: String,
    /// `encoder` or `tape`.
    pub by: String,
    /// `x` or `y`.
    pub axis: String,
    /// What the paper prints (m).
    pub printed_m: f64,
    /// What is simulated as assumed (m).
    pub before_m: f64,
    /// What is simulated with all causes (m).
    pub after_m: f64,
}

impl HeldOut {
    /// What was left out, in words.
    pub fn words(&self) -> &str {
        in_words(&self.left_out)
    }
}

/// An experiment in words; a robot is called by its name.
pub(super) fn in_words(name: &str) -> &str {
    match name {
        "without_limit" => "without the limit",
        "with_limit" => "with the limit",
        robot => robot,
    }
}

impl FinalPosition {
    /// Whether a number agrees with the printed one to within the tape.
    pub fn is_within(&self, number_m: f64) -> bool {
        (number_m - self.printed_m).abs() <= TAPE_M
    }
}

/// An experiment or a robot that was left out: the causes were chosen and fitted without its numbers, and predict them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// `without_limit`, `with_limit`, or the robot.
    pub left_out: String,
    /// The causes that the other numbers show, in words.
    pub causes: Vec<String>,
    /// Root mean square of what is left of the numbers held out without any cause (m).
    pub before_m: f64,
    /// The same with those causes (m).
    pub after_m: f64,
}
