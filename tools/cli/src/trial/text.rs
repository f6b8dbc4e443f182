//! Results of a trial on the terminal.

use crate::print::say;
use slipstream_trial::diagnosis_process::DiagnosisRun;
use slipstream_trial::grade::TrialGrade;
use slipstream_trial::protocol::Question;
use slipstream_trial::tally::{ScoredCase, TrialReport};

/// One answer, before its label is opened.
pub(super) fn say_answer(question: &Question, run: &DiagnosisRun) {
    let said = match &run.answer {
        Ok(answer) if answer.findings.is_empty() => format!("{:?}", answer.verdict).to_lowercase(),
        Ok(answer) => {
            let names = answer.findings.iter();
            let names: Vec<String> = names
                .map(|finding| format!("{} of {}", finding.effect, finding.robot))
                .collect();
            names.join(", ")
        }
        Err(why) => why.clone(),
    };
    say!("{}  {:6.1} s  {said}", question.name, run.seconds);
}

/// The scores.
pub(super) fn say(report: &TrialReport) {
    say!("");
    for entry in &report.each {
        say_case(entry);
    }
    say!(
        "\n{} cases, {} of them with nothing concealed",
        report.cases,
        report.nulls
    );
    for outcome in TrialGrade::ALL {
        let count = report
            .each
            .iter()
            .filter(|entry| entry.score.grade == outcome)
            .count();
        say!("  {:<12} {count}", outcome.name().replace('_', " "));
    }
    for (kind, outcomes) in report.kinds.iter().filter(|(kind, _)| !kind.is_empty()) {
        let counts = outcomes
            .iter()
            .map(|(name, count)| format!("{count} {}", name.replace('_', " ")));
        say!("{kind}: {}", counts.collect::<Vec<_>>().join(", "));
    }
    let figure = |what: &str, value: Option<f64>| {
        if let Some(value) = value {
            say!("{what} {value:.4}");
        }
    };
    figure(
        "share of 95 % intervals that hold the truth:",
        report.coverage95,
    );
    figure(
        "parameter error over the stated deviation (rms):",
        report.error_over_stated,
    );
    figure(
        "parameter error over the least possible deviation (rms):",
        report.error_over_least,
    );
    figure(
        "parameter error in proportion (median):",
        report.median_relative_error,
    );
    figure(
        "prediction error after over before (median):",
        report.held_out_ratio,
    );
    let [median, most] = report.seconds;
    say!("time for one diagnosis: {median:.1} s (median), {most:.1} s (most)");
    if !report.detection.is_empty() {
        say!("\nsize, in nats    effects   named   look-alike   missed");
        for step in &report.detection {
            say!(
                "from {:<12.0}{:6}{:9}{:11}{:10}",
                step.from_gain,
                step.effects,
                step.named,
                step.look_alike,
                step.missed
            );
        }
    }
}

fn say_case(entry: &ScoredCase) {
    let (name, outcome) = (&entry.case, entry.score.grade.name().replace('_', " "));
    let pairs = entry.score.pairs.iter();
    let pairs: Vec<String> = pairs
        .map(|[truth, said]| format!("{truth} → {said}"))
        .collect();
    say!("{name}  {outcome:<12} {}", pairs.join(", "));
    for remark in &entry.score.remarks {
        say!("    {remark}");
    }
}
