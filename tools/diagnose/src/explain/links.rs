//! Messages between robots against where the sender was: how old their content is.

use slipstream_bus::{EffectSpec, RobotModel};
use slipstream_recording::Recording;

use super::finding::{Named, Number};
use crate::answer::{Answer, Evidence, Finding, HeldOutChannel};

/// What is looked for.
const EFFECT: &str = "link_delay";
/// Fewest messages of a link.
const LEAST: usize = 10;
/// Gain (nats) that a delay has to bring.
const PAY: f64 = 15.0;
/// Estimate over deviation.
const SIGMAS: f64 = 4.2;
/// Step of the differences for the delay (s).
const STEP_S: f64 = 1e-3;
/// Rounds of the fit.
const ROUNDS: usize = 20;
/// Longest lag of an autocorrelation (messages), and from where on it is gone.
const LONGEST: usize = 120;
const GONE: f64 = 0.05;

/// Where one robot was, by its fitted model.
pub(crate) struct Course {
    pub(crate) robot: String,
    /// Time (s), x, y (m) and heading (rad).
    points: Vec<(f64, [f64; 3])>,
    /// Deviation of its camera: x, y (m), yaw (rad).
    deviation: [f64; 3],
}

impl Course {
    /// The course of a robot, from points in time (s), x, y (m) and heading (rad).
    pub(crate) fn of(robot: String, points: Vec<(f64, [f64; 3])>, deviation: [f64; 3]) -> Self {
        Self {
            robot,
            points,
            deviation,
        }
    }

    fn at(&self, t_s: f64) -> Option<[f64; 3]> {
        let next = self.points.partition_point(|(at_s, _)| *at_s < t_s);
        let (a_s, a) = *self.points.get(next.checked_sub(1)?)?;
        let (b_s, b) = *self.points.get(next)?;
        // the turn from one window to the next may be a full one
        let near = (b[2] - a[2]).abs() < 1.0;
        let share = if near { (t_s - a_s) / (b_s - a_s) } else { 0.0 };
        Some([0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * share))
    }
}

/// What was sent from one robot to another.
struct SentMessages<'a> {
    course: &'a Course,
    /// When (s) and what.
    sent: Vec<(f64, [f64; 3])>,
}

impl SentMessages<'_> {
    /// Residuals in deviations if the content is `delay_s` old.
    fn residuals(&self, delay_s: f64) -> Vec<f64> {
        let residual = |(t_s, pose): &(f64, [f64; 3])| {
            let was = self.course.at(t_s - delay_s);
            [0, 1, 2].map(|i| {
                let Some(was) = was else { return 0.0 };
                let mut apart = was[i] - pose[i];
                if i == 2 {
                    apart = apart.sin().atan2(apart.cos());
                }
                let residual = apart / self.course.deviation[i];
                if residual.is_finite() { residual } else { 0.0 }
            })
        };
        self.sent.iter().flat_map(residual).collect()
    }

    /// How many times the square of a delay's deviation is that of white noise as declared: the
    /// sender's course is fitted, and wrong for a while where it is wrong.
    fn excess(&self, delay_s: f64) -> f64 {
        let residuals = self.residuals(delay_s);
        let excess = (0..3).map(|part| {
            let own = residuals.iter().skip(part).step_by(3);
            let own: Vec<f64> = own.copied().collect();
            let level = sum(&own) / own.len().max(1) as f64;
            level.max(1.0) * inefficiency(&own)
        });
        excess.fold(1.0, f64::max)
    }

    /// The delay that fits best from `delay_s` on, its deviation, and the sum of squares there.
    fn fit(&self, delay_s: f64) -> (f64, f64, f64) {
        let mut delay_s = delay_s;
        let mut deviation = f64::INFINITY;
        let mut square = sum(&self.residuals(delay_s));
        for _ in 0..ROUNDS {
            let (at, after) = (self.residuals(delay_s), self.residuals(delay_s + STEP_S));
            let slopes: Vec<f64> = at
                .iter()
                .zip(&after)
                .map(|(a, b)| (b - a) / STEP_S)
                .collect();
            let steepness = sum(&slopes);
            if steepness <= 0.0 {
                break;
            }
            deviation = steepness.sqrt().recip();
            let slope: f64 = at.iter().zip(&slopes).map(|(r, s)| r * s).sum();
            let next = (delay_s - slope / steepness).max(0.0);
            let better = sum(&self.residuals(next));
            if better >= square {
                break;
            }
            let done = (next - delay_s).abs() < 1e-3 * deviation;
            (delay_s, square) = (next, better);
            if done {
                break;
            }
        }
        (delay_s, deviation, square)
    }
}

fn sum(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}

/// Adds to `answer` and to the receivers' improved models how old the messages are.
pub(crate) fn add(
    recording: &Recording,
    courses: &[Course],
    excluded: &[String],
    answer: &mut Answer,
    improved: &mut [(String, RobotModel)],
) {
    if excluded.iter().any(|id| id == EFFECT) {
        return;
    }
    let messages = || recording.links.iter().flat_map(|links| &links.messages);
    for course in courses {
        for (receiver, model) in improved.iter_mut() {
            let own = messages().filter(|m| *m.from == *course.robot && *m.to == **receiver);
            let own = own.map(|m| (m.t_sent_s, [m.x_m, m.y_m, m.yaw_rad]));
            let sent: Vec<(f64, [f64; 3])> = own.collect();
            if sent.len() < LEAST {
                continue;
            }
            let link = SentMessages { course, sent };
            let Some(late) = Late::new(&link, receiver, model) else {
                continue;
            };
            answer.held_out.channels.push(late.predicted());
            if late.is_found() {
                answer.findings.push(late.finding());
                let spec = EffectSpec::new(EFFECT, &[("delay_s", late.delay_s)]);
                match model.effects.iter_mut().find(|own| own.effect == EFFECT) {
                    Some(own) => *own = spec,
                    None => model.effects.push(spec),
                }
            }
        }
    }
}

/// Messages that are older than they say.
struct Late<'a> {
    link: &'a SentMessages<'a>,
    receiver: &'a str,
    /// What the receiver's model says (s).
    known: Option<f64>,
    delay_s: f64,
    deviation: f64,
    /// Sums of squares without and with the delay.
    squares: [f64; 2],
    /// ln L that the delay brings.
    gain: f64,
}

impl<'a> Late<'a> {
    /// The delay that fits a link best, beside what the receiver's model says.
    fn new(link: &'a SentMessages<'a>, receiver: &'a str, model: &RobotModel) -> Option<Self> {
        let known = model.number(EFFECT, "delay_s");
        let before = sum(&link.residuals(known.unwrap_or(0.0)));
        let starts = [known.unwrap_or(0.0), 0.03, 0.1, 0.25];
        let fits = starts.iter().map(|start| link.fit(*start));
        let (delay_s, deviation, after) = fits.min_by(|a, b| a.2.total_cmp(&b.2))?;
        let excess = link.excess(delay_s);
        Some(Self {
            link,
            receiver,
            known,
            delay_s,
            deviation: deviation * excess.sqrt(),
            squares: [before, after],
            gain: (before - after) / (2.0 * excess),
        })
    }

    fn is_found(&self) -> bool {
        let change_s = (self.delay_s - self.known.unwrap_or(0.0)).abs();
        self.gain > PAY && change_s > SIGMAS * self.deviation
    }

    /// How well the positions that the receiver hears are predicted.
    fn predicted(&self) -> HeldOutChannel {
        let count = (3 * self.link.sent.len()) as f64;
        let [before, after] = self.squares;
        let after = if self.is_found() { after } else { before };
        let [nrmse_before, nrmse_after] = [before, after].map(|sum| (sum / count).sqrt());
        let camera_m = self.link.course.deviation[0];
        HeldOutChannel {
            robot: self.receiver.to_owned(),
            channel: "link".to_owned(),
            nrmse_before,
            nrmse_after,
            unit: "m",
            rms_before: nrmse_before * camera_m,
            rms_after: nrmse_after * camera_m,
            rms_expected: camera_m,
        }
    }

    fn finding(&self) -> Finding {
        let times = self.link.sent.iter().map(|(t_s, _)| *t_s);
        let span_s = [
            times.clone().fold(f64::INFINITY, f64::min),
            times.fold(0.0, f64::max),
        ];
        let ci95 = [-1.96, 1.96].map(|side| self.delay_s + side * self.deviation);
        let (receiver, sender) = (self.receiver, &self.link.course.robot);
        let [delay, low, high] = [self.delay_s, ci95[0], ci95[1]].map(|s| 1e3 * s);
        let named = Named {
            robot: receiver,
            effect: EFFECT,
            numbers: vec![Number {
                name: "delay_s",
                nominal: self.known,
                estimate: self.delay_s,
                ci95,
            }],
            word: None,
            intervals_s: vec![span_s],
            condition: Some("every message".to_owned()),
            runs: None,
            confused: &[],
            evidence: Evidence {
                log_likelihood_gain: self.gain,
                p_value: (-self.gain).exp().min(1.0),
            },
            known: self.known.is_some(),
        };
        Finding {
            statement: format!(
                "Robot {receiver}, link from {sender}: the positions it receives are {delay:.1} ms \
                 older than their stamps say (95 % between {low:.1} and {high:.1} ms)."
            ),
            ..named.finding(span_s)
        }
    }
}

/// 1 + 2 Σ of the autocorrelation of a series up to where it is gone.
fn inefficiency(series: &[f64]) -> f64 {
    let covariance = |lag: usize| -> f64 {
        let pairs = series.iter().zip(series.iter().skip(lag));
        pairs.map(|(a, b)| a * b).sum()
    };
    let own = covariance(0);
    if own <= 0.0 {
        return 1.0;
    }
    let correlations = (1..LONGEST).map(|lag| covariance(lag) / own);
    let seen = correlations.take_while(|own| *own >= GONE);
    seen.fold(1.0, |sum, own| sum + 2.0 * own)
}
