//! An effect that was found as a finding of the answer.

use slipstream_bus::RobotModel;
use slipstream_sim::effects::find;

use super::claim::{Claim, Law};
use crate::answer::statement::{changed, statement};
use crate::answer::{Evidence, Finding, ParameterEstimate, Place, Unexplained};

/// One effect, whatever found it.
pub(crate) struct Named<'a> {
    pub(crate) robot: &'a str,
    pub(crate) effect: &'static str,
    pub(crate) numbers: Vec<Number>,
    pub(crate) word: Option<(&'static str, &'static str)>,
    /// When it acts (s).
    pub(crate) intervals_s: Vec<[f64; 2]>,
    /// Under which condition it acts, where it is not that of the catalogue.
    pub(crate) condition: Option<String>,
    /// Names of the runs for which it holds; all without them.
    pub(crate) runs: Option<Vec<String>>,
    pub(crate) confused: &'a [&'static str],
    pub(crate) evidence: Evidence,
    /// Whether the model has it with other numbers.
    pub(crate) known: bool,
}

/// A parameter: its value in the nominal model, what it was found to be, and the 95 % interval of that.
pub(crate) struct Number {
    pub(crate) name: &'static str,
    pub(crate) nominal: Option<f64>,
    pub(crate) estimate: f64,
    pub(crate) ci95: [f64; 2],
}

impl Named<'_> {
    /// As a finding of a recording that begins and ends so (s).
    pub(crate) fn finding(self, span_s: [f64; 2]) -> Finding {
        let info = find(self.effect);
        let numbers = self.numbers.into_iter().map(|own| {
            let parameter = info.and_then(|info| info.parameter(own.name));
            ParameterEstimate {
                name: own.name.to_owned(),
                unit: parameter.map_or("1", |own| own.unit).to_owned(),
                nominal: own.nominal,
                nominal_ci95: None,
                estimate: Some(own.estimate),
                ci95: Some(own.ci95),
                text: None,
            }
        });
        let word = self
            .word
            .map(|(name, word)| ParameterEstimate::word(name, word));
        let channel = info.and_then(|info| info.channels.first());
        let condition = || info.map_or("always", |info| info.condition).to_owned();
        let mut finding = Finding {
            robot: self.robot.to_owned(),
            effect: self.effect.to_owned(),
            statement: String::new(),
            parameters: numbers.chain(word).collect(),
            place: Place {
                channel: channel.map_or("longitudinal", |own| own.name()).to_owned(),
                intervals_s: self.intervals_s,
                condition: self.condition.unwrap_or_else(condition),
            },
            runs: self.runs,
            confused_with: self.confused.iter().map(|id| (*id).to_owned()).collect(),
            evidence: self.evidence,
            shape: None,
            driver: None,
            actions: Vec::new(),
        };
        let summary = info.map_or(self.effect, |info| info.summary);
        finding.statement = statement(&finding, summary, span_s, self.known);
        finding
    }
}

/// The finding of a claim about `robot`, and what is unexplained by it; `runs` are the names of all runs, `span_s` when
/// the recording begins and ends.
pub(crate) fn finding(
    claim: &Claim,
    robot: &str,
    runs: &[String],
    model: &RobotModel,
    span_s: [f64; 2],
) -> (Finding, Option<Unexplained>) {
    let evidence = Evidence {
        log_likelihood_gain: claim.gain,
        p_value: claim.p_value,
    };
    if let Some(law) = &claim.law {
        let what = unexplained(law, robot, span_s);
        return (outside(&what, evidence), Some(what));
    }
    let numbers = claim.values.iter().map(|value| {
        let nominal = claim.nominal(model, value.name);
        Number {
            name: value.name,
            nominal,
            estimate: value.estimate(nominal),
            ci95: value.interval(nominal),
        }
    });
    let numbers: Vec<Number> = numbers.collect();
    let own = claim.runs.as_ref();
    let named = Named {
        robot,
        effect: claim.effect,
        known: numbers.iter().any(|own| own.nominal.is_some()),
        numbers,
        word: claim.word,
        intervals_s: vec![span_s],
        condition: None,
        runs: own.map(|own| own.iter().filter_map(|i| runs.get(*i).cloned()).collect()),
        confused: &claim.confused,
        evidence,
    };
    (named.finding(span_s), None)
}

/// What the catalogue does not have of the motion of a robot.
fn unexplained(law: &Law, robot: &str, span_s: [f64; 2]) -> Unexplained {
    Unexplained {
        robot: robot.to_owned(),
        channel: match law.table.acts_on {
            "turn_rate" => "yaw".to_owned(),
            _ => "longitudinal".to_owned(),
        },
        driver: law.table.driver.to_owned(),
        intervals_s: vec![span_s],
        shape: law.shape(),
    }
}

/// The finding of what the catalogue does not have.
pub(crate) fn outside(what: &Unexplained, evidence: Evidence) -> Finding {
    what.finding(format!("follows {}", what.driver), evidence)
}

/// Makes a finding one of what changed since a recording called `before`; `known` are 95 % intervals of parameters there.
pub(crate) fn since(
    finding: &mut Finding,
    before: &str,
    known: impl Fn(&ParameterEstimate) -> Option<[f64; 2]>,
) {
    for parameter in &mut finding.parameters {
        parameter.nominal_ci95 = known(parameter);
    }
    finding.statement = changed(finding, before);
}
