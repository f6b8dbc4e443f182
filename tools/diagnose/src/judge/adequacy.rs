//! The verdict: whether what is left is what noise predicts, and the sentence that says so.

use std::cmp::Ordering;

use super::predictions::Predictions;
use super::score::{HEADING, PLACE, POSE, QUANTITIES, Score, name};
use crate::answer::{Answer, Budget, Unexplained, Verdict};

/// A root mean square error up to so many times what noise predicts is explained by it, and up to so many
/// times it is within the noise (CONTRACT: "What a verdict may say").
const EXPLAINED: f64 = 2.0;
const WITHIN: f64 = 1.2;
/// Findings explain something where an error falls below this share of the one before.
const BETTER: f64 = 0.98;
/// A model that misses more than this share of the way that the robot goes does not tell its motion, whatever noise
/// would explain that.
const MISSED: f64 = 1.0 / 3.0;
/// Fewest windows: with one, nothing is left that the fit has not seen.
const WINDOWS: usize = 2;
/// An error (m, rad and their rates) that nobody would call one.
const NOTHING: f64 = 1e-3;

/// The heading as a channel.
const POSE_YAW: usize = POSE + 2;

/// The quantity that is furthest from what noise predicts, and how many times that it is.
#[derive(Debug, Clone, Copy)]
struct Excess {
    quantity: usize,
    ratio: f64,
}

impl Predictions {
    fn excess(&self) -> Option<Excess> {
        // x and y are judged together, as position
        let all = (0..QUANTITIES).filter(|quantity| ![POSE, POSE + 1].contains(quantity));
        let all = all.filter_map(|quantity| {
            let square = self.after.mean_square(quantity)?;
            let ratio = (square / self.after.expected(quantity)?).sqrt();
            (square.sqrt() > NOTHING).then_some(Excess { quantity, ratio })
        });
        all.max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    /// Whether some quantity is predicted better with the findings, or to the noise of its sensor.
    fn explains(&self) -> bool {
        (0..QUANTITIES).any(|quantity| {
            let pair = |score: &Score| score.mean_square(quantity);
            let both = pair(&self.before).zip(pair(&self.after));
            let sensor = self.after.sensor(quantity).unwrap_or(0.0);
            both.is_some_and(|(before, after)| {
                after < BETTER * BETTER * before || after < WITHIN * WITHIN * sensor
            })
        })
    }

    /// The share of the robot's way that predictions miss, where it is too much for any noise.
    fn missed(&self) -> Option<f64> {
        self.after.missed_share().filter(|share| *share > MISSED)
    }

    /// When a quantity is further off than noise explains (s).
    fn intervals_s(&self, quantity: usize) -> Vec<[f64; 2]> {
        let mut intervals: Vec<[f64; 2]> = Vec::new();
        for ([from_s, to_s], score) in self.windows() {
            let off = score
                .mean_square(quantity)
                .zip(score.expected(quantity))
                .is_some_and(|(square, expected)| square > EXPLAINED * EXPLAINED * expected);
            match intervals.last_mut() {
                Some(last) if off && *from_s - last[1] < 1e-6 => last[1] = *to_s,
                _ if off => intervals.push([*from_s, *to_s]),
                _ => {}
            }
        }
        intervals
    }

    /// What remains, as an entry of `unexplained`.
    fn remainder(&self, excess: Excess) -> Unexplained {
        let Excess { quantity, ratio } = excess;
        let error = self.after.mean_square(quantity).unwrap_or(0.0).sqrt();
        Unexplained {
            robot: self.robot.clone(),
            channel: channel(quantity).to_owned(),
            driver: "t".to_owned(),
            intervals_s: self.intervals_s(quantity),
            shape: format!(
                "{}: predictions over 5 s miss by {}, {ratio:.1} times what the noise of the sensors and the \
                 reported process noise explain",
                name(quantity),
                size(error, quantity),
            ),
        }
    }
}

/// An entry of `unexplained` for predictions that miss a share of the way.
fn missed(machine: &Predictions, share: f64) -> Unexplained {
    Unexplained {
        robot: machine.robot.clone(),
        channel: channel(PLACE).to_owned(),
        driver: "t".to_owned(),
        intervals_s: Vec::new(),
        shape: format!(
            "predictions over 5 s miss {:.0} % of the way that the robot goes: no noise, but another motion",
            100.0 * share
        ),
    }
}

/// The channel of the vocabulary in which an error of a quantity shows.
fn channel(quantity: usize) -> &'static str {
    match name(quantity) {
        own @ ("wheel_right" | "wheel_left") => own,
        "pose_yaw" | "odometry_w" | "imu_gz" | "heading" => "yaw",
        "imu_ay" => "lateral",
        _ => "longitudinal",
    }
}

/// An error in the unit that a person uses.
fn size(error: f64, quantity: usize) -> String {
    let (factor, unit) = match name(quantity) {
        "position" if error < 1.0 => (100.0, "cm"),
        "position" => (1.0, "m"),
        "pose_yaw" | "heading" => (1.0_f64.to_degrees(), "degrees"),
        "odometry_v" => (1.0, "m/s"),
        "imu_ax" | "imu_ay" => (1.0, "m/s²"),
        "odometry_w" | "imu_gz" => (1.0_f64.to_degrees(), "degrees/s"),
        _ => (1.0, "rad of the wheel"),
    };
    let value = error * factor;
    let digits = if value.abs() < 1.0 { 2 } else { 1 };
    format!("{value:.digits$} {unit}")
}

/// Draws verdict and statement of an answer from its findings and from what the judge saw.
pub(crate) fn conclude(answer: &mut Answer, machines: &[Predictions]) {
    let rank = |(own, excess): &(&Predictions, Excess)| {
        let first = excess.ratio > EXPLAINED || own.missed().is_some();
        (first, excess.ratio)
    };
    let worst = machines
        .iter()
        .filter_map(|own| Some((own, own.excess()?)))
        .max_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap_or(Ordering::Equal));
    let untested = !machines.is_empty() && machines.iter().all(|own| own.seen() < WINDOWS);
    let idle = !answer.findings.is_empty() && answer.against.is_empty();
    let idle = idle && !machines.iter().any(Predictions::explains);
    let left = untested || idle || worst.as_ref().is_some_and(|own| rank(own).0);
    let beside = !answer.unexplained.is_empty();
    for own in machines {
        if let Some(excess) = own.excess().filter(|own| own.ratio > EXPLAINED) {
            answer.unexplained.push(own.remainder(excess));
        } else if let Some(share) = own.missed() {
            answer.unexplained.push(missed(own, share));
        }
    }
    answer.verdict = match (answer.findings.is_empty(), left || beside) {
        (_, true) => Verdict::Unexplained,
        (true, false) => Verdict::Match,
        (false, false) => Verdict::Explained,
    };
    answer.statement = match worst {
        _ if untested => untested_statement(answer, worst),
        Some((machine, excess)) => statement(answer, machine, excess, beside),
        None => unpredicted(answer.verdict).to_owned(),
    };
}

/// Where there is nothing to predict.
fn unpredicted(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Match => {
            "Match: nothing was found that the model lacks; nothing could be predicted over 5 s"
        }
        Verdict::Explained => {
            "Explained by the findings below; nothing could be predicted over 5 s"
        }
        Verdict::Unexplained => "Unexplained: something outside of the catalogue acts",
    }
}

/// Where nothing was left to test the findings on.
fn untested_statement(answer: &Answer, worst: Option<(&Predictions, Excess)>) -> String {
    let found = match worst {
        Some((machine, _)) if !answer.findings.is_empty() => {
            let excess = Excess {
                quantity: PLACE,
                ratio: 1.0,
            };
            let explained = MachineNumbers::new(answer, machine, excess).explained("");
            format!("the findings below explain {explained}")
        }
        _ if answer.findings.is_empty() => "nothing was found that the model lacks".to_owned(),
        _ => "the findings below fit".to_owned(),
    };
    format!(
        "Not tested: {found}, but the recording leaves no 5 s to test it on that the fit has not seen"
    )
}

fn statement(answer: &Answer, machine: &Predictions, excess: Excess, beside: bool) -> String {
    let numbers = MachineNumbers::new(answer, machine, excess);
    let whose = if answer.robots().len() > 1 {
        format!(" of robot {}", machine.robot)
    } else {
        String::new()
    };
    if !answer.against.is_empty() {
        return changes(answer, &numbers, &whose);
    }
    let MachineNumbers { after, times, .. } = &numbers;
    let explained = numbers.explained(&whose);
    match answer.verdict {
        Verdict::Match if excess.ratio <= WITHIN => {
            format!("Match: the model predicts the recording to within noise ({after} over 5 s)")
        }
        Verdict::Match => format!(
            "Match: nothing was found that the model lacks; 5 s ahead it misses by {after}, {times} what noise \
             explains"
        ),
        Verdict::Explained if excess.ratio <= WITHIN => format!(
            "Explained: with the findings below, the model predicts the recording to within noise; they explain \
             {explained}"
        ),
        Verdict::Explained => format!(
            "Explained: the findings below explain {explained}; {after} are left, {times} what noise explains"
        ),
        Verdict::Unexplained => unexplained(answer, machine, &numbers, &explained, beside),
    }
}

fn unexplained(
    answer: &Answer,
    machine: &Predictions,
    numbers: &MachineNumbers,
    explained: &str,
    beside: bool,
) -> String {
    let MachineNumbers { after, limit, .. } = numbers;
    let known = answer.findings.iter().any(|own| own.effect != "unknown");
    let mut text = match (known, beside) {
        (true, false) => format!(
            "Partly explained: the findings explain {explained}; {after} are left, {limit}, and follow nothing that was looked at"
        ),
        (true, true) => format!(
            "Partly explained: the findings explain {explained}; {after} are left, and something outside of the \
             catalogue acts"
        ),
        (false, true) => format!(
            "Not explained: something outside of the catalogue acts; 5 s ahead the model misses by {after}, {limit}"
        ),
        (false, false) => {
            format!("Not explained: {after} remain over 5 s, {limit}")
        }
    };
    if !machine.refused.is_empty() {
        let names: Vec<String> = machine
            .refused
            .iter()
            .map(|id| id.replace('_', " "))
            .collect();
        text += &format!(
            "; {} would fit best but predict worse than the model without, and are not named",
            names.join(", ")
        );
    }
    if !known && let Some(first) = answer.warnings.first() {
        text += &format!("; first look at this: {}", first.statement);
    }
    text
}

/// What changed.
fn changes(answer: &Answer, numbers: &MachineNumbers, whose: &str) -> String {
    let before = answer.against.join(", ");
    let MachineNumbers { after, noise, .. } = numbers;
    let known = answer.findings.iter().any(|own| own.effect != "unknown");
    match answer.verdict {
        Verdict::Match => {
            format!("Match: nothing changed since {before}; 5 s ahead it misses by {after}")
        }
        Verdict::Explained => format!(
            "Explained: the findings below changed since {before}; with them the model misses by {after} over 5 s"
        ),
        Verdict::Unexplained if known => format!(
            "Partly explained: what changed since {before} explains {}; {after} are left over 5 s, where {noise} \
             would be left without a change",
            numbers.explained(whose)
        ),
        Verdict::Unexplained => format!(
            "Unexplained: what changed since {before} is not explained; {after} are left over 5 s, where {noise} would \
             be left without a change"
        ),
    }
}

/// What a sentence says of one machine: its position, else its heading, else what is furthest off.
struct MachineNumbers {
    before: String,
    after: String,
    noise: String,
    /// What the error is measured by.
    limit: String,
    times: String,
    /// Share of the error that the findings take away.
    share: f64,
}

impl MachineNumbers {
    fn new(answer: &Answer, machine: &Predictions, excess: Excess) -> Self {
        let own = |unit: &str| -> Option<&Budget> {
            let mut all = answer.budget.iter();
            all.find(|own| own.robot == machine.robot && own.unit == unit)
        };
        // an excess that shows in a channel alone is told by that channel
        let told = match excess.quantity {
            HEADING | POSE_YAW if excess.ratio > EXPLAINED => own("rad").map(|_| HEADING),
            own if own < PLACE && excess.ratio > EXPLAINED => Some(own),
            _ => own("m").map(|_| PLACE).or(own("rad").map(|_| HEADING)),
        };
        let quantity = told.unwrap_or(excess.quantity);
        let root = |square: Option<f64>| square.unwrap_or(0.0).sqrt();
        let before = root(machine.before.mean_square(quantity));
        let after = root(machine.after.mean_square(quantity));
        let noise = size(root(machine.after.expected(quantity)), quantity);
        let limit = match machine.missed() {
            Some(share) if excess.ratio <= EXPLAINED => {
                format!("{:.0} % of the way that the robot goes", 100.0 * share)
            }
            _ => format!("where noise explains {noise}"),
        };
        Self {
            before: size(before, quantity),
            after: size(after, quantity),
            noise,
            limit,
            times: format!("{:.1} times", excess.ratio),
            share: 1.0 - after / before.max(1e-300),
        }
    }

    fn explained(&self, whose: &str) -> String {
        let percent = (100.0 * self.share).floor();
        let part = if percent < 1.0 {
            "less than 1 %".to_owned()
        } else {
            format!("{percent:.0} %")
        };
        format!("{part} of {}{whose}", self.before)
    }
}
