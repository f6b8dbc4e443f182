//! What an answer says against its own numbers.

use slipstream_answer::{Answer, Budget, Verdict};

/// Parts of a budget add up to within this share of it.
const ROUNDING: f64 = 1e-9;
/// Multiples of the predicted error up to which a verdict may be `match` or `explained`, and up to which it may say
/// "to within noise".
const EXPLAINED: f64 = 2.0;
const WITHIN: f64 = 1.2;
/// An error that nobody would call one (m, rad and their rates).
const NOTHING: f64 = 1e-3;

/// Every contradiction of an answer, in words.
pub(crate) fn contradictions(answer: &Answer) -> Vec<String> {
    let mut all = Vec::new();
    let budgets = answer.budget.iter();
    let of_budgets = budgets.map(|own| (own.after, own.expected, NOTHING));
    // the position stands for x and y
    let left_out = ["link", "pose_x", "pose_y"];
    let channels = answer.held_out.channels.iter();
    let channels = channels.filter(|own| !left_out.contains(&own.channel.as_str()));
    let of_channels = channels.map(|own| (own.rms_after, own.rms_expected, NOTHING));
    let off = of_budgets
        .chain(of_channels)
        .filter(|(after, _, least)| after > least)
        .map(|(after, expected, _)| after / expected.max(1e-300))
        .fold(0.0, f64::max);
    let certain = answer.verdict != Verdict::Unexplained;
    if certain && off > EXPLAINED {
        all.push(format!(
            "{:?} beside {off:.1} times the noise",
            answer.verdict
        ));
    }
    if answer.statement.contains("to within noise") && off > WITHIN {
        all.push(format!(
            "\"to within noise\" beside {off:.2} times the noise"
        ));
    }
    if answer.verdict == Verdict::Match && !answer.findings.is_empty() {
        all.push("match with findings".to_owned());
    }
    if answer.verdict == Verdict::Explained && answer.findings.is_empty() {
        all.push("explained without findings".to_owned());
    }
    if answer.statement.is_empty() {
        all.push("no statement".to_owned());
    }
    all.extend(answer.budget.iter().flat_map(of_budget));
    all
}

fn of_budget(own: &Budget) -> Vec<String> {
    let mut all = Vec::new();
    let mut add = |what: String| all.push(format!("{} {}: {what}", own.robot, own.unit));
    let is_left = |name: &str| ["unexplained", "sensor noise"].contains(&name);
    let sum = |left: bool| -> f64 {
        let parts = own.parts.iter().filter(|part| !left || is_left(&part.name));
        parts.map(|part| part.share).sum()
    };
    for part in &own.parts {
        if !(part.share >= 0.0 && part.share <= own.before * (1.0 + ROUNDING)) {
            add(format!(
                "part {} is {} of {}",
                part.name, part.share, own.before
            ));
        }
    }
    if (sum(false) - own.before).abs() > ROUNDING * own.before {
        add(format!("parts add up to {} of {}", sum(false), own.before));
    }
    // what is left beyond the error before was not there to be shared out
    if (sum(true) - own.after.min(own.before)).abs() > ROUNDING * own.before {
        add(format!(
            "what is left adds up to {} of {}",
            sum(true),
            own.after
        ));
    }
    all
}

/// Units that a set of findings predicts worse than the model without, by more than 2 %.
pub(crate) fn worse(answer: &Answer) -> Vec<String> {
    let worse = answer
        .budget
        .iter()
        .filter(|own| own.after > 1.02 * own.before);
    worse
        .map(|own| {
            format!(
                "{} {}: {:.4} after {:.4}",
                own.robot, own.unit, own.after, own.before
            )
        })
        .collect()
}
