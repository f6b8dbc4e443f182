//! Texts of a diagnosis: verdict, warnings, differences, numbers.

use slipstream_answer::{Answer, Budget, Unexplained, Warning};

/// A warning about a recording, in one line.
pub(super) fn warning(warning: &Warning) -> String {
    let robot = warning.robot.as_deref().unwrap_or("all robots");
    let (name, what, remedy) = (&warning.recording, &warning.statement, &warning.remedy);
    format!("{name}, {robot}: {what}; {remedy}")
}

/// The unexplained differences that no finding states already.
pub(super) fn unstated(answer: &Answer) -> impl Iterator<Item = &Unexplained> {
    let is_stated = |shape: &str| {
        let mut findings = answer.findings.iter();
        findings.any(|finding| finding.shape.as_deref() == Some(shape))
    };
    let differences = answer.unexplained.iter();
    differences.filter(move |difference| !is_stated(&difference.shape))
}

/// Parts of a budget below this share of it are left out.
pub(super) const SMALL_PART: f64 = 0.01;

/// An error in centimetres or degrees. `unit` is that of a budget.
pub(super) fn size(value: f64, unit: &str) -> String {
    let (factor, unit) = match unit {
        "m" => (100.0, "cm"),
        _ => (1.0_f64.to_degrees(), "degrees"),
    };
    format!("{} {unit}", short(value * factor))
}

fn short(size: f64) -> String {
    if size.abs() < 1.0 {
        format!("{size:.2}")
    } else {
        format!("{size:.1}")
    }
}

/// Parts of a budget that no finding takes away.
const LEFT: [&str; 2] = ["unexplained", "sensor noise"];

/// What the findings make of the error of one robot, in centimetres or degrees.
pub(super) fn budget(budget: &Budget, horizon_s: f64) -> String {
    let size = |value: f64| size(value, budget.unit);
    let what = if budget.unit == "m" {
        "position"
    } else {
        "heading"
    };
    let is_found = |part: &slipstream_answer::BudgetPart| !LEFT.contains(&part.name.as_str());
    let robot = &budget.robot;
    let mut text = format!(
        "Robot {robot}: {what} error over {horizon_s:.0} s: {} rms",
        size(budget.before)
    );
    if budget.parts.iter().any(is_found) {
        text += &format!(" with the model, {} with the findings", size(budget.after));
    }
    for part in &budget.parts {
        if part.share.abs() > SMALL_PART * budget.before {
            match part.name.as_str() {
                "unexplained" => text += &format!("; {} follow no pattern", size(part.share)),
                "sensor noise" => text += &format!("; {} are sensor noise", size(part.share)),
                _ => {}
            }
        }
    }
    text
}

/// What only some want to know: evidence, outliers, what always pushes, and what would have been found.
pub(super) fn details(answer: &Answer) -> String {
    let mut lines = vec![String::new()];
    for own in &answer.findings {
        let (gain, p) = (own.evidence.log_likelihood_gain, own.evidence.p_value);
        let effect = &own.effect;
        lines.push(format!("{effect}: {gain:.1} nats of evidence, p = {p:.1e}"));
    }
    for own in &answer.held_out.channels {
        let (channel, unit) = (&own.channel, own.unit);
        lines.push(format!(
            "{} {channel}: {:.4} {unit} rms before, {:.4} {unit} after",
            own.robot, own.rms_before, own.rms_after
        ));
    }
    for own in &answer.outliers {
        let (robot, stream, count) = (&own.robot, &own.stream, own.count);
        lines.push(format!(
            "{robot} {stream}: {count} rows are weighed down as outliers"
        ));
    }
    for own in &answer.process_noise {
        let (robot, on, size, unit) = (&own.robot, &own.acts_on, own.size, &own.unit);
        lines.push(format!(
            "{robot} {on}: pushed at random by {size:.3} {unit}"
        ));
    }
    for own in &answer.detectable {
        let (robot, effect, name, unit) = (&own.robot, own.effect, own.parameter, own.unit);
        lines.push(match own.smallest {
            Some(size) => {
                format!("{robot} {effect} {name}: would have been found from {size:.3} {unit} on")
            }
            None => format!("{robot} {effect} {name}: cannot be seen in these recordings"),
        });
    }
    lines.push(String::new());
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_told_in_centimetres() {
        let part = |name: &str, share: f64| slipstream_answer::BudgetPart {
            name: name.to_owned(),
            share,
        };
        let own = Budget {
            robot: "r1".to_owned(),
            unit: "m",
            before: 0.352,
            after: 0.041,
            expected: 0.04,
            parts: vec![
                part("pose_offset", 0.181),
                part("wheel_radius", 0.137),
                part("pose_latency", 0.001),
                part("unexplained", 0.028),
                part("sensor noise", 0.005),
            ],
        };
        assert_eq!(
            budget(&own, 5.0),
            "Robot r1: position error over 5 s: 35.2 cm rms with the model, 4.1 cm with the findings; 2.8 cm follow no \
             pattern; 0.50 cm are sensor noise"
        );
    }
}
