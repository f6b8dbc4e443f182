//! The page of a trial: grades, detection by size, parameter errors, confusion.

use slipstream_report::{Chart, Histogram, Line, Page, PictureError};

use crate::grade::TrialGrade;
use crate::tally::{ScoredCase, TrialReport};

/// The report of a trial, made by `command`.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn page(report: &TrialReport, command: &str) -> Result<String, PictureError> {
    let mut page = Page::new("Sealed trial of the diagnosis", command);
    page.paragraph(&summary(report));
    grades(&mut page, report);
    sizes(&mut page, report)?;
    estimates(&mut page, report)?;
    confusion(&mut page, report);
    every_case(&mut page, report);
    if !report.commitments.is_empty() {
        page.section("Commitments");
        page.paragraph(
            "SHA-256 of a nonce, a line feed and the label, written before the first diagnosis.",
        );
        page.verbatim(&report.commitments.join("\n"));
    }
    Ok(page.end())
}

fn summary(report: &TrialReport) -> String {
    let TrialReport {
        cases,
        nulls,
        exact,
        wrong,
        false_alarms,
        missed,
        failed,
        ..
    } = report;
    let [median, longest] = report.seconds;
    format!(
        "{cases} cases, {nulls} of them without a concealed effect: {exact} exact, {missed} missed, \
         {wrong} wrong, {false_alarms} false alarms, {failed} without an answer. A diagnosis took \
         {median:.1} s (median), at most {longest:.1} s."
    )
}

fn grades(page: &mut Page, report: &TrialReport) {
    page.section("Grades");
    let mut head = vec!["cases"];
    let names: Vec<String> = TrialGrade::ALL
        .iter()
        .map(|grade| grade.name().replace('_', " "))
        .collect();
    head.extend(names.iter().map(String::as_str));
    let kinds = report.kinds.iter().map(|(kind, counts)| {
        let kind = if kind.is_empty() { "all" } else { kind };
        let count = |grade: &TrialGrade| counts.get(grade.name()).copied().unwrap_or(0);
        let counts = TrialGrade::ALL
            .iter()
            .map(|grade| count_or_empty(count(grade)));
        std::iter::once(kind.to_owned()).chain(counts).collect()
    });
    page.table(&head, &kinds.collect::<Vec<Vec<String>>>());
}

/// A count; empty for zero.
fn count_or_empty(count: usize) -> String {
    if count == 0 {
        String::new()
    } else {
        count.to_string()
    }
}

fn sizes(page: &mut Page, report: &TrialReport) -> Result<(), PictureError> {
    if report.detection.is_empty() {
        return Ok(());
    }
    page.section("Detection by size");
    let share = |count: fn(&crate::tally::DetectionRate) -> usize| {
        let points = report.detection.iter().map(move |step| {
            let middle = (4.0 * step.from_gain).log10();
            (middle, 100.0 * count(step) as f64 / step.effects as f64)
        });
        points.collect::<Vec<_>>()
    };
    let identified = Line::new("identified", share(|step| step.named));
    let either = Line::new(
        "identified, or a declared look-alike",
        share(|step| step.named + step.look_alike),
    );
    let chart = Chart::new("log10 of the expected gain (nats)", "effects found (%)");
    let chart = chart.line(identified).line(either.dashed());
    page.figure(
        &chart.svg()?,
        "The expected gain is the log-likelihood gain of the true model over the model without the effect. \
         An effect of nine standard deviations has 40 nats, at 1.6 on this axis.",
    );
    Ok(())
}

fn estimates(page: &mut Page, report: &TrialReport) -> Result<(), PictureError> {
    let parameters = || report.each.iter().flat_map(|entry| &entry.score.parameters);
    let stated: Vec<f64> = parameters()
        .filter_map(|p| p.error_in_stated_deviations)
        .filter(|error| error.is_finite())
        .map(|error| error.clamp(-6.0, 6.0))
        .collect();
    if stated.is_empty() {
        return Ok(());
    }
    page.section("Parameter errors");
    let figure = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.4}"));
    page.table(
        &["figure", "value"],
        &[
            row(
                "95 % intervals that contain the true value (share)",
                figure(report.coverage95),
            ),
            row(
                "error over the stated standard deviation (rms)",
                figure(report.error_over_stated),
            ),
            row(
                "error over the least possible standard deviation (rms)",
                figure(report.error_over_least),
            ),
            row(
                "relative error (median)",
                figure(report.median_relative_error),
            ),
            row(
                "prediction error with findings over nominal (median)",
                figure(report.held_out_ratio),
            ),
        ],
    );
    let histogram = Histogram::new(
        "error over the stated standard deviation",
        "parameters",
        stated,
    );
    page.figure(
        &histogram.svg()?,
        "All estimated parameters; values beyond 6 are counted at 6.",
    );
    Ok(())
}

fn row(name: &str, value: String) -> Vec<String> {
    vec![name.to_owned(), value]
}

fn confusion(page: &mut Page, report: &TrialReport) {
    page.section("Confusion");
    let rows = report.confusion.iter().map(|(truth, said)| {
        let said = said.iter().map(|(name, count)| format!("{name} ({count})"));
        vec![truth.clone(), said.collect::<Vec<_>>().join(", ")]
    });
    page.table(
        &["true effect", "reported effect (count)"],
        &rows.collect::<Vec<_>>(),
    );
}

fn every_case(page: &mut Page, report: &TrialReport) {
    page.section("All cases");
    let head = [
        "case",
        "kind",
        "true effect",
        "reported effect",
        "grade",
        "remarks",
        "prediction error, nominal → with findings",
        "time (s)",
    ];
    page.table(&head, &report.each.iter().map(case).collect::<Vec<_>>());
}

fn case(entry: &ScoredCase) -> Vec<String> {
    let side = |at: usize| {
        let names = entry.score.pairs.iter().map(|pair| pair[at].as_str());
        names.collect::<Vec<_>>().join(", ")
    };
    let held_out = entry.score.held_out;
    vec![
        entry.case.clone(),
        entry.kind.clone(),
        side(0),
        side(1),
        entry.score.grade.name().replace('_', " "),
        entry.score.remarks.join("; "),
        held_out.map_or(String::new(), |[before, after]| {
            format!("{before:.2} → {after:.2}")
        }),
        format!("{:.1}", entry.seconds),
    ]
}
