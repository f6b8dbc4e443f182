//! Texts of a diagnosis: verdict, warnings, differences, numbers.

use slipstream_diagnose::{Answer, Budget, Unexplained, Verdict, Warning};

/// The verdict as a sentence.
pub(super) fn verdict(answer: &Answer) -> String {
    if !answer.against.is_empty() {
        let before = answer.against.join(", ");
        return match answer.verdict {
            Verdict::Match => format!("Match: nothing changed since {before}"),
            Verdict::Explained => format!("Explained: the findings below changed since {before}"),
            Verdict::Unexplained => {
                format!("Unexplained: something outside of the catalogue changed since {before}")
            }
        };
    }
    let words = match answer.verdict {
        Verdict::Match => "Match: the model predicts the recording to within sensor noise",
        Verdict::Explained => {
            "Explained: with the findings below, the model predicts the recording to within sensor noise"
        }
        Verdict::Unexplained => {
            "Unexplained: a difference remains that no effect of the catalogue explains"
        }
    };
    words.to_owned()
}

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
const SMALL_PART: f64 = 0.01;

/// Where the error of one robot went, in centimetres or degrees.
pub(super) fn budget(budget: &Budget, horizon_s: f64) -> String {
    let (factor, unit) = match budget.unit {
        "m" => (100.0, "cm"),
        _ => (1.0_f64.to_degrees(), "degrees"),
    };
    let number = |value: f64| match value * factor {
        size if size.abs() < 1.0 => format!("{size:.2}"),
        size => format!("{size:.1}"),
    };
    let parts = budget.parts.iter();
    let parts = parts.filter(|part| part.share.abs() > SMALL_PART * budget.before);
    let words: Vec<String> = parts
        .map(|part| match part.name.as_str() {
            "unexplained" => format!("{} follow no pattern", number(part.share)),
            "sensor noise" => format!("{} are sensor noise", number(part.share)),
            "unknown" => format!("what no effect explains {}", number(part.share)),
            effect => format!("{} {}", effect.replace('_', " "), number(part.share)),
        })
        .collect();
    format!(
        "Robot {}: of {} {unit} rms over {horizon_s:.0} s: {}; {} {unit} are left with the findings",
        budget.robot,
        number(budget.before),
        words.join(", "),
        number(budget.after),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_told_in_centimetres() {
        let part = |name: &str, share: f64| slipstream_diagnose::BudgetPart {
            name: name.to_owned(),
            share,
        };
        let own = Budget {
            robot: "r1".to_owned(),
            unit: "m",
            before: 0.352,
            after: 0.041,
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
            "Robot r1: of 35.2 cm rms over 5 s: pose offset 18.1, wheel radius 13.7, 2.8 follow no \
             pattern, 0.50 are sensor noise; 4.1 cm are left with the findings"
        );
    }
}
