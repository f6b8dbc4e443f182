//! What is answered; its JSON has a schema in `tools/cli/schemas`.

use serde::Serialize;
use slipstream_sim::effects::Info;

use crate::windows::bench::Bench;
use crate::windows::force::Part;
use crate::windows::hypothesis::Hypothesis;
use crate::windows::input::Warning;
use crate::windows::misfit::Misfit;
use crate::windows::score;
use crate::windows::statement::statement;
use crate::windows::track::{CHANNEL_NAMES, CHANNELS};
use crate::windows::unknown::Unknown;
use crate::windows::wander::{EXPLAINED, Wander};
use crate::windows::weigh::Found;
use crate::windows::{interval, located};

/// The answer of a diagnosis.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Answer {
    /// Version of this form.
    pub format: u32,
    /// What it comes to.
    pub verdict: Verdict,
    /// What the model leaves out.
    pub findings: Vec<Finding>,
    /// Prediction before and after.
    pub held_out: HeldOut,
    /// What remains.
    pub unexplained: Vec<Unexplained>,
    /// What about the recordings makes the answer poorer.
    pub warnings: Vec<Warning>,
}

/// What a diagnosis comes to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing beyond the noise was found.
    #[default]
    Match,
    /// The findings bring the residuals to noise.
    Explained,
    /// Something significant remains.
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
}

/// A parameter with its interval.
#[derive(Debug, Clone, Serialize)]
pub struct ParameterEstimate {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What the model says.
    pub nominal: Option<f64>,
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

/// Level of the worst channel (deviations) from which on residuals that nothing explains are said
/// to be unexplained; below, they may be forces without pattern.
const GROSS: f64 = 3.0;

impl Answer {
    /// Adds what was found on one machine.
    pub(crate) fn add(&mut self, bench: &Bench, found: &Found) {
        self.format = 1;
        for (at, hypothesis) in found.node.hypotheses.iter().enumerate() {
            self.findings.push(finding(bench, found, hypothesis, at));
        }
        self.leftover(bench, found);
        if found.stopped {
            self.warnings.push(stopped(bench));
        }
    }

    /// Adds how well one machine is predicted before and after.
    pub(crate) fn judge(
        &mut self,
        bench: &Bench,
        hypotheses: &[Hypothesis],
        unknown: Option<&Unknown>,
    ) {
        let before = score::prediction(bench, &bench.windows, &[]);
        let after = score::held_out(bench, hypotheses, unknown);
        self.held_out.add(&bench.tracks[0].robot, &before, &after);
    }

    /// What the fitted model leaves beyond the noise.
    fn leftover(&mut self, bench: &Bench, found: &Found) {
        let robot = bench.tracks[0].robot.clone();
        let looked_at = found.looked_at;
        if let Some(unknown) = &found.unknown {
            let what = Unexplained {
                robot,
                channel: unknown.missing.part.name().to_owned(),
                driver: unknown.missing.driver.name.to_owned(),
                intervals_s: unknown.intervals_s.clone(),
                shape: unknown.shape.clone(),
            };
            let condition = format!("follows {}", what.driver);
            self.outside(what, condition, unknown.gain, looked_at);
            return;
        }
        match found.wander {
            Some((wander, _)) if wander.is_noise(bench) => {
                self.warnings.push(wandering(bench, &wander));
                return;
            }
            Some((wander, gain)) if wander.rest < EXPLAINED => {
                let [along, about] = wander.strengths(bench);
                let channel = if along > about { "longitudinal" } else { "yaw" };
                let kind = if bench.lacks_motion() {
                    "motions"
                } else {
                    "forces"
                };
                let sizes = sizes(bench, &wander);
                let what = Unexplained {
                    robot,
                    channel: channel.to_owned(),
                    driver: "t".to_owned(),
                    intervals_s: vec![bench.tracks[0].span_s()],
                    shape: format!("{kind} that follow no variable looked at, {sizes}"),
                };
                let condition = "all the time".to_owned();
                self.outside(what, condition, gain, looked_at);
                return;
            }
            _ => {}
        }
        let (worst, level) = bench.worst(&found.node);
        if bench.is_noise(&found.node) || level < GROSS {
            return;
        }
        let channel = [
            "wheel_right",
            "wheel_left",
            "longitudinal",
            "lateral",
            "yaw",
            "longitudinal",
            "yaw",
            "longitudinal",
            "lateral",
            "yaw",
        ][worst];
        let shape = format!(
            "residuals of {level:.1} standard deviations in {} that follow no variable looked at",
            CHANNEL_NAMES[worst]
        );
        let [from, to] = bench.tracks[0].span_s();
        self.unexplained.push(Unexplained {
            robot,
            channel: channel.to_owned(),
            driver: "t".to_owned(),
            intervals_s: vec![[from, to]],
            shape,
        });
    }

    /// Adds what the catalogue does not hold, as a finding and as unexplained.
    fn outside(&mut self, what: Unexplained, condition: String, gain: f64, looked_at: usize) {
        self.findings
            .push(outside(&what, condition, gain, looked_at));
        self.unexplained.push(what);
    }

    /// Draws the verdict from what was added.
    pub(crate) fn conclude(&mut self) {
        self.verdict = match (self.findings.is_empty(), self.unexplained.is_empty()) {
            (_, false) => Verdict::Unexplained,
            (true, true) => Verdict::Match,
            (false, true) => Verdict::Explained,
        };
    }
}

impl HeldOut {
    fn add(&mut self, robot: &str, before: &Misfit, after: &Misfit) {
        for (channel, name) in CHANNEL_NAMES.iter().enumerate().take(CHANNELS) {
            let levels = score::level(before, channel).zip(score::level(after, channel));
            if let Some((nrmse_before, nrmse_after)) = levels {
                self.channels.push(HeldOutChannel {
                    robot: robot.to_owned(),
                    channel: (*name).to_owned(),
                    nrmse_before,
                    nrmse_after,
                });
            }
        }
        // several robots: the one that is worst off
        self.nrmse_before = self.nrmse_before.max(score::total(before));
        self.nrmse_after = self.nrmse_after.max(score::total(after));
    }
}

fn finding(bench: &Bench, found: &Found, hypothesis: &Hypothesis, at: usize) -> Finding {
    let info: &Info = hypothesis.info;
    let unit = |name: &str| {
        let own = info.parameter(name);
        own.map_or("1", |p| p.unit).to_owned()
    };
    let intervals = interval::of(bench, &found.node, at);
    let mut parameters: Vec<ParameterEstimate> = hypothesis
        .values
        .iter()
        .enumerate()
        .map(|(i, (name, estimate))| ParameterEstimate {
            name: (*name).to_owned(),
            unit: unit(name),
            nominal: hypothesis.nominal(&bench.model, name),
            estimate: Some(*estimate),
            ci95: Some(intervals[i]),
            text: None,
        })
        .collect();
    if let Some((name, word)) = hypothesis.text {
        parameters.push(ParameterEstimate {
            name: name.to_owned(),
            unit: "text".to_owned(),
            nominal: None,
            estimate: None,
            ci95: None,
            text: Some(word.to_owned()),
        });
    }
    let gain = found.gains.get(at).copied().unwrap_or(0.0);
    let confused: Vec<String> = found
        .twins
        .get(at)
        .into_iter()
        .flatten()
        .map(|id| (*id).to_owned())
        .collect();
    let robot = bench.tracks[0].robot.clone();
    let condition = located::condition(bench, hypothesis);
    let known = hypothesis.replaces.is_some();
    let mut finding = Finding {
        statement: String::new(),
        robot,
        effect: info.id.to_owned(),
        parameters,
        place: Place {
            channel: info.channels[0].name().to_owned(),
            intervals_s: located::intervals(bench, &found.node, at),
            condition,
        },
        confused_with: confused,
        // over all hypotheses that were tried, by Bonferroni
        evidence: Evidence {
            log_likelihood_gain: gain,
            p_value: (found.looked_at as f64 * (-gain).exp()).min(1.0),
        },
        shape: None,
        driver: None,
    };
    finding.statement = statement(&finding, info.summary, bench.tracks[0].span_s(), known);
    finding
}

/// How large forces without pattern are.
fn sizes(bench: &Bench, wander: &Wander) -> String {
    let [along, about] = wander.level.size;
    let memory_s = wander.level.memory_s;
    let [[what, unit], [turn, turn_unit]] =
        [Part::Longitudinal, Part::Yaw].map(|part| part.quantity(bench.lacks_motion()));
    format!(
        "of {along:.2e} {unit} ({what}) and {about:.2e} {turn_unit} ({turn}; standard deviations), \
         each lasting about {memory_s:.2} s"
    )
}

/// What there is to say of how a robot was diagnosed.
fn warning(bench: &Bench, id: &str, statement: String, remedy: &str) -> Warning {
    Warning {
        recording: bench.tracks[0].recording.clone(),
        robot: Some(bench.tracks[0].robot.clone()),
        id: id.to_owned(),
        statement,
        remedy: remedy.to_owned(),
    }
}

/// The search came to its end before everything was tried.
fn stopped(bench: &Bench) -> Warning {
    let statement = "the search was stopped for the work that it took: there may be more effects than were found";
    let remedy = "put what was found into the model with --improved and diagnose again, or leave out effects that it cannot be with --without";
    warning(bench, "search_stopped", statement.to_owned(), remedy)
}

/// What is left are forces without pattern.
fn wandering(bench: &Bench, wander: &Wander) -> Warning {
    let sizes = sizes(bench, wander);
    let statement = format!("what is left is as forces without pattern leave it, {sizes}");
    let remedy = "effects that do not stand out from them were not accepted; a smoother floor or a longer recording would show more";
    warning(bench, "wandering_forces", statement, remedy)
}

/// A finding that the catalogue does not hold.
fn outside(what: &Unexplained, condition: String, gain: f64, looked_at: usize) -> Finding {
    let Unexplained { robot, shape, .. } = what;
    Finding {
        robot: robot.clone(),
        effect: "unknown".to_owned(),
        statement: format!("Robot {robot}: something outside of the catalogue: {shape}."),
        parameters: Vec::new(),
        place: Place {
            channel: what.channel.clone(),
            intervals_s: what.intervals_s.clone(),
            condition,
        },
        confused_with: Vec::new(),
        evidence: Evidence {
            log_likelihood_gain: gain,
            p_value: (looked_at as f64 * (-gain).exp()).min(1.0),
        },
        shape: Some(shape.clone()),
        driver: Some(what.driver.clone()),
    }
}
