//! A trial as a page: what came out, what was taken for what, down to what size, how sure.

use slipstream_report::{Chart, Histogram, Line, Page, PictureError};

use crate::mark::Outcome;
use crate::tally::{Entry, Report};

/// The report of a trial, made by `command`.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn page(report: &Report, command: &str) -> Result<String, PictureError> {
    let mut page = Page::new(
        "Is the diagnosis right where the truth is concealed?",
        command,
    );
    page.paragraph(&summary(report));
    outcomes(&mut page, report);
    sizes(&mut page, report)?;
    estimates(&mut page, report)?;
    confusion(&mut page, report);
    every_case(&mut page, report);
    if !report.commitments.is_empty() {
        page.section("Commitments");
        page.paragraph(
            "SHA-256 of a nonce, a line feed and the label, written before anything was diagnosed.",
        );
        page.verbatim(&report.commitments.join("\n"));
    }
    Ok(page.end())
}

fn summary(report: &Report) -> String {
    let Report {
        cases,
        nulls,
        exact,
        wrong,
        false_alarms,
        missed,
        failed,
        ..
    } = report;
    let [median, most] = report.seconds;
    format!(
        "{cases} cases, {nulls} of them with nothing concealed: {exact} exact, {missed} missed, \
         {wrong} named wrong, {false_alarms} false alarms, {failed} without an answer. A diagnosis \
         took {median:.1} s (median), {most:.1} s at most."
    )
}

fn outcomes(page: &mut Page, report: &Report) {
    page.section("What came out");
    let mut head = vec!["cases"];
    let names: Vec<String> = Outcome::ALL
        .iter()
        .map(|o| o.name().replace('_', " "))
        .collect();
    head.extend(names.iter().map(String::as_str));
    let kinds = report.kinds.iter().map(|(kind, counts)| {
        let kind = if kind.is_empty() { "all" } else { kind };
        let count = |outcome: &Outcome| counts.get(outcome.name()).copied().unwrap_or(0);
        let counts = Outcome::ALL.iter().map(|outcome| plain(count(outcome)));
        std::iter::once(kind.to_owned()).chain(counts).collect()
    });
    page.table(&head, &kinds.collect::<Vec<Vec<String>>>());
}

/// A count; nothing where it is none.
fn plain(count: usize) -> String {
    if count == 0 {
        String::new()
    } else {
        count.to_string()
    }
}

fn sizes(page: &mut Page, report: &Report) -> Result<(), PictureError> {
    if report.detection.is_empty() {
        return Ok(());
    }
    page.section("Down to what size");
    let share = |count: fn(&crate::tally::Detection) -> usize| {
        let points = report.detection.iter().map(move |step| {
            let middle = (4.0 * step.from_gain).log10();
            (middle, 100.0 * count(step) as f64 / step.effects as f64)
        });
        points.collect::<Vec<_>>()
    };
    let named = Line::new("named", share(|step| step.named));
    let either = Line::new(
        "named, or a declared look-alike",
        share(|step| step.named + step.look_alike),
    );
    let chart = Chart::new("log10 of the expected gain (nats)", "effects found (%)");
    let chart = chart.line(named).line(either.dashed());
    page.figure(
        &chart.svg()?,
        "The expected gain is the log-likelihood by which the true model beats the one without the \
         effect: nine deviations are 40 nats, 1.6 here.",
    );
    Ok(())
}

fn estimates(page: &mut Page, report: &Report) -> Result<(), PictureError> {
    let parameters = || report.each.iter().flat_map(|entry| &entry.mark.parameters);
    let stated: Vec<f64> = parameters()
        .filter_map(|p| p.error_in_stated_deviations)
        .filter(|error| error.is_finite())
        .map(|error| error.clamp(-6.0, 6.0))
        .collect();
    if stated.is_empty() {
        return Ok(());
    }
    page.section("How much, how sure");
    let figure = |value: Option<f64>| value.map_or("–".to_owned(), |value| format!("{value:.4}"));
    page.table(
        &["figure", "value"],
        &[
            row(
                "95 % intervals that hold the truth (share)",
                figure(report.coverage95),
            ),
            row(
                "error over the stated deviation (rms)",
                figure(report.error_over_stated),
            ),
            row(
                "error over the least possible deviation (rms)",
                figure(report.error_over_least),
            ),
            row(
                "error in proportion (median)",
                figure(report.median_relative_error),
            ),
            row(
                "prediction error after over before (median)",
                figure(report.held_out_ratio),
            ),
        ],
    );
    let histogram = Histogram::new("error over the stated deviation", "parameters", stated);
    page.figure(
        &histogram.svg()?,
        "All estimated parameters; what lies beyond 6 is counted at 6.",
    );
    Ok(())
}

fn row(name: &str, value: String) -> Vec<String> {
    vec![name.to_owned(), value]
}

fn confusion(page: &mut Page, report: &Report) {
    page.section("What was taken for what");
    let rows = report.confusion.iter().map(|(truth, said)| {
        let said = said.iter().map(|(name, count)| format!("{name} ({count})"));
        vec![truth.clone(), said.collect::<Vec<_>>().join(", ")]
    });
    page.table(
        &["what was there", "what was named (how often)"],
        &rows.collect::<Vec<_>>(),
    );
}

fn every_case(page: &mut Page, report: &Report) {
    page.section("Every case");
    let head = [
        "case",
        "kind",
        "what was there",
        "what was said",
        "outcome",
        "remarks",
        "before → after",
        "time (s)",
    ];
    page.table(&head, &report.each.iter().map(case).collect::<Vec<_>>());
}

fn case(entry: &Entry) -> Vec<String> {
    let side = |at: usize| {
        let names = entry.mark.pairs.iter().map(|pair| pair[at].as_str());
        names.collect::<Vec<_>>().join(", ")
    };
    let held_out = entry.mark.held_out;
    vec![
        entry.case.clone(),
        entry.kind.clone(),
        side(0),
        side(1),
        entry.mark.outcome.name().replace('_', " "),
        entry.mark.remarks.join("; "),
        held_out.map_or(String::new(), |[before, after]| {
            format!("{before:.2} → {after:.2}")
        }),
        format!("{:.1}", entry.seconds),
    ]
}
