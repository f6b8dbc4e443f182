//! Messages between robots against where the sender was: how old their content is.

use slipstream_bus::{EffectSpec, RobotModel};
use slipstream_recording::Recording;
use slipstream_sim::effects::find;

use crate::answer::{Answer, Evidence, Finding, HeldOutChannel, ParameterEstimate, Place};

/// Gain (nats) that a delay has to bring.
const PAY: f64 = 15.0;
/// Estimate over deviation.
const SIGMAS: f64 = 4.2;
/// Step of the differences for the delay (s).
const STEP_S: f64 = 1e-3;
/// Rounds of the fit.
const ROUNDS: usize = 20;

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
struct Link<'a> {
    course: &'a Course,
    /// When (s) and what.
    sent: Vec<(f64, [f64; 3])>,
}

impl Link<'_> {
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
            level.max(1.0) * inefficiency(&[own])
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
    let Some(links) = &recording.links else {
        return;
    };
    let Some(info) = find("link_delay").filter(|info| !excluded.iter().any(|id| id == info.id))
    else {
        return;
    };
    for course in courses {
        for (receiver, model) in improved.iter_mut() {
            let own = links
                .messages
                .iter()
                .filter(|m| *m.from == *course.robot && *m.to == **receiver);
            let sent: Vec<_> = own
                .map(|m| (m.t_sent_s, [m.x_m, m.y_m, m.yaw_rad]))
                .collect();
            if sent.len() < 10 {
                continue;
            }
            let link = Link { course, sent };
            let listed = model.effects.iter().position(|spec| spec.effect == info.id);
            let known = listed.and_then(|at| delay_of(&model.effects[at]));
            let before = sum(&link.residuals(known.unwrap_or(0.0)));
            let starts = [known.unwrap_or(0.0), 0.03, 0.1, 0.25];
            let fits = starts.iter().map(|start| link.fit(*start));
            let Some((delay_s, deviation, after)) = fits.min_by(|a, b| a.2.total_cmp(&b.2)) else {
                continue;
            };
            let count = (3 * link.sent.len()) as f64;
            let excess = link.excess(delay_s);
            let deviation = deviation * excess.sqrt();
            let gain = (before - after) / (2.0 * excess);
            let found = gain > PAY && (delay_s - known.unwrap_or(0.0)).abs() > SIGMAS * deviation;
            let [nrmse_before, nrmse_after] =
                [before, if found { after } else { before }].map(|sum| (sum / count).sqrt());
            answer.held_out.channels.push(HeldOutChannel {
                robot: receiver.clone(),
                channel: "link".to_owned(),
                nrmse_before,
                nrmse_after,
                unit: "m",
                rms_before: nrmse_before * link.course.deviation[0],
                rms_after: nrmse_after * link.course.deviation[0],
                rms_expected: link.course.deviation[0],
            });
            if !found {
                continue;
            }
            let late = Late {
                receiver,
                sender: &course.robot,
                known,
                delay_s,
                deviation,
                gain,
            };
            answer.findings.push(late.finding(&link));
            let spec = EffectSpec::new(info.id, &[("delay_s", delay_s)]);
            match listed {
                Some(at) => model.effects[at] = spec,
                None => model.effects.push(spec),
            }
        }
    }
}

/// Messages that are older than they say.
struct Late<'a> {
    receiver: &'a str,
    sender: &'a str,
    /// What the receiver's model says (s).
    known: Option<f64>,
    delay_s: f64,
    deviation: f64,
    /// ln L that the delay brings.
    gain: f64,
}

impl Late<'_> {
    fn finding(&self, link: &Link<'_>) -> Finding {
        let times = link.sent.iter().map(|(t_s, _)| *t_s);
        let span = [
            times.clone().fold(f64::INFINITY, f64::min),
            times.fold(0.0, f64::max),
        ];
        let ci95 = [-1.96, 1.96].map(|side| self.delay_s + side * self.deviation);
        let (receiver, sender) = (self.receiver, self.sender);
        let [delay, low, high] = [self.delay_s, ci95[0], ci95[1]].map(|s| 1e3 * s);
        Finding {
            runs: None,
            robot: receiver.to_owned(),
            effect: "link_delay".to_owned(),
            statement: format!(
                "Robot {receiver}, link from {sender}: the positions it receives are {delay:.1} ms \
                 older than their stamps say (95 % between {low:.1} and {high:.1} ms)."
            ),
            parameters: vec![ParameterEstimate {
                name: "delay_s".to_owned(),
                unit: "s".to_owned(),
                nominal: self.known,
                nominal_ci95: None,
                estimate: Some(self.delay_s),
                ci95: Some(ci95),
                text: None,
            }],
            place: Place {
                channel: "link".to_owned(),
                intervals_s: vec![span],
                condition: "every message".to_owned(),
            },
            confused_with: Vec::new(),
            evidence: Evidence {
                log_likelihood_gain: self.gain,
                p_value: (-self.gain).exp().min(1.0),
            },
            shape: None,
            driver: None,
            actions: Vec::new(),
        }
    }
}

fn delay_of(spec: &EffectSpec) -> Option<f64> {
    spec.parameters
        .iter()
        .find_map(|(name, value)| match value {
            slipstream_bus::Parameter::Number(number) if name == "delay_s" => Some(*number),
            _ => None,
        })
}

/// 1 + 2 Σ of the autocorrelation over all series up to where it is gone.
fn inefficiency(series: &[Vec<f64>]) -> f64 {
    const LONGEST: usize = 120;
    let covariance = |lag: usize| -> f64 {
        let sums = series.iter().map(|s| {
            s.iter()
                .zip(s.iter().skip(lag))
                .map(|(a, b)| a * b)
                .sum::<f64>()
        });
        sums.sum()
    };
    let own = covariance(0);
    if own <= 0.0 {
        return 1.0;
    }
    let mut sum = 1.0;
    for lag in 1..LONGEST {
        let correlation = covariance(lag) / own;
        if correlation < 0.05 {
            break;
        }
        sum += 2.0 * correlation;
    }
    sum
}
