//! What the older engine answers.

use slipstream_sim::effects::Info;

use crate::answer::statement::statement;
use crate::answer::{
    Answer, Evidence, Finding, HeldOut, HeldOutChannel, ParameterEstimate, Place, Unexplained,
    Warning,
};

use crate::windows::bench::Bench;
use crate::windows::force::Part;
use crate::windows::hypothesis::Hypothesis;
use crate::windows::misfit::Misfit;
use crate::windows::score;
use crate::windows::track::{CHANNEL_NAMES, CHANNELS, Sensor};
use crate::windows::unknown::Unknown;
use crate::windows::wander::{EXPLAINED, Wander};
use crate::windows::weigh::Found;
use crate::windows::window::WINDOW_S;
use crate::windows::{interval, located};

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
        self.held_out.add(bench, &before, &after);
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
        let evidence = Evidence {
            log_likelihood_gain: gain,
            p_value: (looked_at as f64 * (-gain).exp()).min(1.0),
        };
        self.findings.push(what.finding(condition, evidence));
        self.unexplained.push(what);
    }
}

impl HeldOut {
    pub(crate) fn add(&mut self, bench: &Bench, before: &Misfit, after: &Misfit) {
        self.horizon_s = WINDOW_S;
        let deviation = |channel: usize| bench.deviation(channel);
        let angles = bench.tracks[0].of(Sensor::WheelAngle).is_some();
        for (channel, name) in CHANNEL_NAMES.iter().enumerate().take(CHANNELS) {
            let levels = score::level(before, channel).zip(score::level(after, channel));
            if let Some((nrmse_before, nrmse_after)) = levels {
                self.channels.push(HeldOutChannel {
                    robot: bench.tracks[0].robot.clone(),
                    channel: (*name).to_owned(),
                    nrmse_before,
                    nrmse_after,
                    unit: unit(channel, angles),
                    rms_before: nrmse_before * deviation(channel),
                    rms_after: nrmse_after * deviation(channel),
                });
            }
        }
        // several robots: the one that is worst off
        self.nrmse_before = self.nrmse_before.max(score::total(before));
        self.nrmse_after = self.nrmse_after.max(score::total(after));
    }
}

/// Unit of a channel; wheels are measured by `angles` or by speeds.
fn unit(channel: usize, angles: bool) -> &'static str {
    match CHANNEL_NAMES[channel] {
        "wheel_right" | "wheel_left" if angles => "rad",
        "pose_x" | "pose_y" => "m",
        "pose_yaw" => "rad",
        "odometry_v" => "m/s",
        "imu_ax" | "imu_ay" => "m/s²",
        _ => "rad/s",
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
        parameters.push(ParameterEstimate::word(name, word));
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
        runs: None,
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
