//! Results of a trial on the terminal.

use crate::exit::Exit;
use crate::print::print_line;
use slipstream_trial::diagnosis_process::DiagnosisRun;
use slipstream_trial::grade::TrialGrade;
use slipstream_trial::protocol::Question;
use slipstream_trial::tally::{NuisanceCounts, ScoredCase, TrialReport};

/// How a trial ends; an interrupted one says so last.
pub(super) fn ended(interrupted: bool) -> Exit {
    if !interrupted {
        return Exit::Done;
    }
    print_line!("\nInterrupted: the remaining cases are missing.");
    Exit::Interrupted
}

/// Prints one answer, before its label is opened.
pub(super) fn print_answer(question: &Question, run: &DiagnosisRun) {
    let summary = match &run.answer {
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
    print_line!("{}  {:6.1} s  {summary}", question.name, run.seconds);
}

/// Prints the scores of all cases.
pub(super) fn print_report(report: &TrialReport) {
    print_line!("");
    for entry in &report.each {
        print_case(entry);
    }
    print_line!(
        "\n{} cases, {} of them without a concealed effect",
        report.cases,
        report.nulls
    );
    for outcome in TrialGrade::ALL {
        let count = report
            .each
            .iter()
            .filter(|entry| entry.score.grade == outcome)
            .count();
        print_line!("  {:<12} {count}", outcome.name().replace('_', " "));
    }
    print_line!(
        "  {} refused, {} contradict their own error, {} predict a unit worse than the nominal model",
        report.refused,
        report.contradictions,
        report.worse
    );
    print_families(report);
    print_nuisances(report);
    let print_figure = |what: &str, value: Option<f64>| {
        if let Some(value) = value {
            print_line!("{what} {value:.4}");
        }
    };
    print_figure(
        "fraction of 95 % intervals that contain the truth:",
        report.coverage95,
    );
    print_figure(
        "parameter error / stated standard deviation (rms):",
        report.error_over_stated,
    );
    print_figure(
        "parameter error / Cramér-Rao bound (rms):",
        report.error_over_least,
    );
    print_figure(
        "relative parameter error (median):",
        report.median_relative_error,
    );
    print_figure(
        "prediction error after / before (median):",
        report.held_out_ratio,
    );
    if let Some([median, max]) = report.seconds {
        print_line!("time for one diagnosis: {median:.1} s (median), {max:.1} s (maximum)");
    }
    if !report.detection.is_empty() {
        print_line!("\nsize (nats)      effects   named   look-alike   missed");
        for step in &report.detection {
            print_line!(
                "from {:<12.0}{:7}{:8}{:13}{:9}",
                step.from_gain,
                step.effects,
                step.named,
                step.look_alike,
                step.missed
            );
        }
    }
}

/// Prints the cases of each kind by grade; `other` is inexact, look alike, flagged and failed.
fn print_families(report: &TrialReport) {
    let named = || report.families.iter().filter(|(kind, _)| !kind.is_empty());
    let width = named().map(|(kind, _)| kind.len()).max();
    let Some(width) = width.map(|width| width.max("kind".len())) else {
        return;
    };
    print_line!(
        "\n{:<width$}  cases  exact  missed  wrong  false alarms  other",
        "kind"
    );
    for (kind, counts) in named() {
        let other = counts.inexact + counts.look_alike + counts.flagged + counts.failed;
        print_line!(
            "{kind:<width$}{:7}{:7}{:8}{:7}{:14}{other:7}",
            counts.cases,
            counts.exact,
            counts.missed,
            counts.wrong,
            counts.false_alarms
        );
    }
    print_line!("");
}

/// Prints what came of the cases with each nuisance. A case counts for each that it has.
fn print_nuisances(report: &TrialReport) {
    let Some(width) = report.nuisances.keys().map(String::len).max() else {
        return;
    };
    let names = NuisanceCounts::default().columns().map(|(name, _)| name);
    let heads: String = names.map(|name| format!("  {name}")).concat();
    print_line!("{:<width$}{heads}", "nuisance");
    for (name, counts) in &report.nuisances {
        let cells = counts
            .columns()
            .map(|(head, count)| format!("  {count:>0$}", head.len()));
        print_line!("{name:<width$}{}", cells.concat());
    }
    print_line!("");
}

/// Prints grade, matched effects and remarks of one case.
fn print_case(entry: &ScoredCase) {
    let (name, outcome) = (&entry.case, entry.score.grade.name().replace('_', " "));
    let pairs = entry.score.pairs.iter();
    let pairs: Vec<String> = pairs
        .map(|[truth, answer]| format!("{truth} → {answer}"))
        .collect();
    print_line!("{name}  {outcome:<12} {}", pairs.join(", "));
    for remark in &entry.score.remarks {
        print_line!("    {remark}");
    }
}
