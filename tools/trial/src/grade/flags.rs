//! What is noted of an answer whatever its grade: its words against its own numbers.

use super::score::AnswerFlag;
use crate::answer::DiagnosisAnswer;
use crate::label::DiagnosisVerdict;

/// Prediction error after the findings, in standard deviations of the sensors, up to which any verdict may stand.
const CONFIDENT_NRMSE: f64 = 3.0;
/// Share of the prediction error that may remain beside a confident verdict.
const CONFIDENT_SHARE: f64 = 0.5;
/// Ratio from which on an error with the findings is larger than without: what rounding does is less.
const WORSE_RATIO: f64 = 1.02;

/// What is noted of an answer.
pub(super) fn flags(answer: &DiagnosisAnswer) -> Vec<AnswerFlag> {
    let noted = [
        (contradicts_itself(answer), AnswerFlag::Contradiction),
        (predicts_worse(answer), AnswerFlag::Worse),
    ];
    let noted = noted.into_iter().filter(|(is_so, _)| *is_so);
    noted.map(|(_, flag)| flag).collect()
}

/// Whether a confident verdict stands beside an error that it does not allow.
fn contradicts_itself(answer: &DiagnosisAnswer) -> bool {
    let held_out = answer
        .held_out
        .and_then(|own| Some((own.nrmse_before?, own.nrmse_after?)));
    let too_large =
        |(before, after): (f64, f64)| after > f64::max(CONFIDENT_NRMSE, CONFIDENT_SHARE * before);
    answer.verdict != DiagnosisVerdict::Unexplained && held_out.is_some_and(too_large)
}

/// Whether a line of the budget grows by the findings.
fn predicts_worse(answer: &DiagnosisAnswer) -> bool {
    let mut lines = answer.budget.iter();
    lines.any(|line| line.after > WORSE_RATIO * line.before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::parse;

    fn flags_of(text: &str) -> Vec<AnswerFlag> {
        flags(&parse(text).unwrap())
    }

    #[test]
    fn a_confident_verdict_needs_a_small_error() {
        let text =
            r#"{"verdict": "explained", "held_out": {"nrmse_before": 8.0, "nrmse_after": 4.1}}"#;
        assert_eq!(flags_of(text), [AnswerFlag::Contradiction]);
        assert_eq!(flags_of(&text.replace("4.1", "3.9")), []);
        assert_eq!(
            flags_of(&text.replace("8.0", "2.0").replace("4.1", "2.9")),
            []
        );
        assert_eq!(flags_of(&text.replace("explained", "unexplained")), []);
    }

    #[test]
    fn a_line_of_the_budget_must_not_grow() {
        let text = r#"{"verdict": "match", "budget": [{"before": 1.0, "after": 0.5},
            {"before": 1.0, "after": 1.03}]}"#;
        assert_eq!(flags_of(text), [AnswerFlag::Worse]);
        assert_eq!(flags_of(&text.replace("1.03", "1.01")), []);
    }
}
