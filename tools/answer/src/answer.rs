//! The answer and its parts, as its JSON has them.

use serde::Serialize;

/// The answer of a diagnosis.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Answer {
    /// Version of this form.
    pub format: u32,
    /// What it comes to.
    pub verdict: Verdict,
    /// The verdict as a sentence for a person, with its numbers.
    pub statement: String,
    /// Recordings from before that these were compared with; `findings` are then what changed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub against: Vec<String>,
    /// What the model leaves out.
    pub findings: Vec<Finding>,
    /// Prediction before and after.
    pub held_out: HeldOut,
    /// Where the error went.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub budget: Vec<Budget>,
    /// What remains.
    pub unexplained: Vec<Unexplained>,
    /// Rows that were weighed down.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outliers: Vec<Outliers>,
    /// What always pushes and follows nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub process_noise: Vec<ProcessNoise>,
    /// From which size on what was not found would have been found.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub detectable: Vec<Detectable>,
    /// What about the recordings makes the answer poorer.
    pub warnings: Vec<Warning>,
}

/// What would have been found, and down to which size.
#[derive(Debug, Clone, Serialize)]
pub struct Detectable {
    /// On which robot.
    pub robot: String,
    /// The effect's identity.
    pub effect: &'static str,
    /// Its parameter.
    pub parameter: &'static str,
    /// Unit of the parameter.
    pub unit: &'static str,
    /// The smallest difference from the nominal value, or of a comparison from the value before, that would
    /// have been found; of a factor, from 1. `None`: these recordings do not show it at any size.
    pub smallest: Option<f64>,
}

/// What a diagnosis comes to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing was found, and the error over the horizon is at most twice what noise explains.
    #[default]
    Match,
    /// With the findings it is.
    Explained,
    /// More remains, or nothing was left to test the findings on.
    Unexplained,
}

/// One effect that the model leaves out.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// Whose.
    pub robot: String,
    /// Its identity in the vocabulary, or `unknown`.
    pub effect: String,
    /// One sentence for a person.
    pub statement: String,
    /// How much.
    pub parameters: Vec<ParameterEstimate>,
    /// Where.
    #[serde(rename = "where")]
    pub place: Place,
    /// Runs for which it holds; all without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<Vec<String>>,
    /// What this recording cannot tell it from.
    pub confused_with: Vec<String>,
    /// How sure.
    pub evidence: Evidence,
    /// Of an effect outside of the catalogue: what it looks like.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// Of an effect outside of the catalogue: the variable that it follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driver: Option<String>,
    /// What to do about it: what to type or turn, the most useful first.
    pub actions: Vec<String>,
}

impl Finding {
    /// What to do about it, without the experiment that its statement names already.
    pub fn actions_beside_statement(&self) -> impl Iterator<Item = &str> {
        let is_stated = |action: &&str| {
            let experiment = action.split_once(": ").map(|(_, experiment)| experiment);
            experiment.is_some_and(|words| self.statement.contains(words))
        };
        let all = self.actions.iter().map(String::as_str);
        all.filter(move |action| !is_stated(action))
    }
}

/// A parameter with its interval.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterEstimate {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What the model says; of a change, what it was before.
    pub nominal: Option<f64>,
    /// Of a change, where it lay before with 95 % confidence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_ci95: Option<[f64; 2]>,
    /// What the recording says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimate: Option<f64>,
    /// Where it lies with 95 % confidence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
    /// The value of a parameter that is a word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

impl ParameterEstimate {
    /// A parameter that is a word.
    pub fn word(name: &str, word: &str) -> Self {
        Self {
            name: name.to_owned(),
            unit: "text".to_owned(),
            nominal: None,
            nominal_ci95: None,
            estimate: None,
            ci95: None,
            text: Some(word.to_owned()),
        }
    }
}

impl Unexplained {
    /// What the catalogue does not hold, as a finding.
    pub fn finding(&self, condition: String, evidence: Evidence) -> Finding {
        let Self { robot, shape, .. } = self;
        Finding {
            robot: robot.clone(),
            effect: "unknown".to_owned(),
            statement: format!("Robot {robot}: something outside of the catalogue: {shape}."),
            parameters: Vec::new(),
            place: Place {
                channel: self.channel.clone(),
                intervals_s: self.intervals_s.clone(),
                condition,
            },
            runs: None,
            confused_with: Vec::new(),
            evidence,
            shape: Some(shape.clone()),
            driver: Some(self.driver.clone()),
            actions: Vec::new(),
        }
    }
}

/// Where a finding shows.
#[derive(Debug, Clone, Serialize)]
pub struct Place {
    /// The channel.
    pub channel: String,
    /// When it is at work (s).
    pub intervals_s: Vec<[f64; 2]>,
    /// Under which condition.
    pub condition: String,
}

/// How sure a finding is.
#[derive(Debug, Clone, Serialize)]
pub struct Evidence {
    /// Nats on the data of the fit.
    pub log_likelihood_gain: f64,
    /// Over everything that was looked at.
    pub p_value: f64,
}

/// Prediction over 5 s before and after.
#[derive(Debug, Clone, Default, Serialize)]
pub struct HeldOut {
    /// Each channel.
    pub channels: Vec<HeldOutChannel>,
    /// All pose channels before.
    pub nrmse_before: f64,
    /// All pose channels after.
    pub nrmse_after: f64,
    /// Over how long a time it is predicted (s).
    pub horizon_s: f64,
}

/// Prediction of one channel.
#[derive(Debug, Clone, Serialize)]
pub struct HeldOutChannel {
    /// Whose.
    pub robot: String,
    /// Which.
    pub channel: String,
    /// Deviations before.
    pub nrmse_before: f64,
    /// Deviations after.
    pub nrmse_after: f64,
    /// Unit of the channel.
    pub unit: &'static str,
    /// Root mean square error before, in that unit.
    pub rms_before: f64,
    /// Root mean square error after, in that unit.
    pub rms_after: f64,
    /// Root mean square error below which the sensors' noise and the reported process noise stay with 95 %
    /// confidence; of what changed, what the recordings from before miss.
    pub rms_expected: f64,
}

/// What remains.
#[derive(Debug, Clone, Serialize)]
pub struct Unexplained {
    /// Whose.
    pub robot: String,
    /// In which channel.
    pub channel: String,
    /// On what it depends.
    pub driver: String,
    /// When (s).
    pub intervals_s: Vec<[f64; 2]>,
    /// What it looks like.
    pub shape: String,
}

/// Where the error of one robot's prediction went.
#[derive(Debug, Clone, Serialize)]
pub struct Budget {
    /// Whose.
    pub robot: String,
    /// `m` for the position, `rad` for the heading.
    pub unit: &'static str,
    /// Root mean square error over the horizon before.
    pub before: f64,
    /// The same after.
    pub after: f64,
    /// The same as `rms_expected` of a channel.
    pub expected: f64,
    /// Shares that add up to `before`.
    pub parts: Vec<BudgetPart>,
}

/// A part of a budget.
#[derive(Debug, Clone, Serialize)]
pub struct BudgetPart {
    /// An effect, several that help together (`a + b`), `unexplained` or `sensor noise`.
    pub name: String,
    /// Its share, in the unit of the budget.
    pub share: f64,
}

impl Budget {
    /// The part of an effect, by itself or together with others.
    pub fn part_of(&self, effect: &str) -> Option<&BudgetPart> {
        let is_of = |part: &&BudgetPart| part.name.split(" + ").any(|own| own == effect);
        self.parts.iter().find(is_of)
    }
}

impl BudgetPart {
    /// Whether several effects share it.
    pub fn is_shared(&self) -> bool {
        self.name.contains(" + ")
    }
}

/// Rows of a stream that were weighed down.
#[derive(Debug, Clone, Serialize)]
pub struct Outliers {
    /// Whose.
    pub robot: String,
    /// Of which stream.
    pub stream: &'static str,
    /// How many.
    pub count: usize,
    /// Their stamps (s).
    pub times_s: Vec<f64>,
}

/// What always pushes and follows nothing that was looked at.
#[derive(Debug, Clone, Serialize)]
pub struct ProcessNoise {
    /// Whose.
    pub robot: String,
    /// On what it acts.
    pub acts_on: &'static str,
    /// Its standard deviation.
    pub size: f64,
    /// Its unit.
    pub unit: &'static str,
    /// How long it lasts (s).
    pub correlation_time_s: f64,
}

/// Something about a recording that makes the answer poorer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Warning {
    /// The recording.
    pub recording: String,
    /// The robot; null when it is about all.
    pub robot: Option<String>,
    /// A word for programs, such as `gaps`.
    pub id: String,
    /// What it is.
    pub statement: String,
    /// What to do about it.
    pub remedy: String,
}

impl HeldOut {
    /// Adds the prediction of one machine; the totals are those of the one that is worst off.
    pub fn merge(&mut self, other: &Self) {
        self.channels.extend(other.channels.iter().cloned());
        self.nrmse_before = self.nrmse_before.max(other.nrmse_before);
        self.nrmse_after = self.nrmse_after.max(other.nrmse_after);
        self.horizon_s = other.horizon_s;
    }
}

impl Answer {
    /// The robots that were predicted.
    pub fn robots(&self) -> Vec<&str> {
        let mut robots: Vec<&str> = Vec::new();
        for channel in &self.held_out.channels {
            if !robots.contains(&channel.robot.as_str()) {
                robots.push(&channel.robot);
            }
        }
        robots
    }
}
