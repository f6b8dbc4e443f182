//! Report page of a diagnosis: the answer first, then the figures behind it.

use slipstream_diagnose::{
    Answer, Figures, Finding, Limit, ParameterEstimate, Seen, Verdict, manoeuvre,
};
use slipstream_report::{Page, PictureError};

use super::charts::{FOUND, NOMINAL, add_forces, add_paths, add_residuals, add_timeline};
use super::text::{format_number, unstated, verdict, warning};
use crate::command_line::command_line;

/// The whole page.
pub(super) fn page(
    name: &str,
    answer: &Answer,
    figures: &[Figures],
) -> Result<String, PictureError> {
    let mut page = Page::new(&format!("Diagnosis of {name}"), &command_line());
    add_answer(&mut page, answer);
    let found = |own: &Figures| answer.findings.iter().any(|f| f.robot == own.robot);
    // Robots with findings come first.
    let (with, without): (Vec<&Figures>, Vec<&Figures>) =
        figures.iter().partition(|own| found(own));
    for own in with.into_iter().chain(without) {
        if figures.len() > 1 {
            let nothing = if found(own) { "" } else { ": no finding" };
            page.section(&format!("Robot {}{nothing}", own.robot));
        }
        add_residuals(&mut page, own)?;
        add_timeline(&mut page, answer, own)?;
        add_forces(&mut page, own)?;
        add_paths(&mut page, own)?;
        add_parameters(&mut page, answer, own);
        add_prediction_errors(&mut page, answer, own);
        add_limits(&mut page, own);
        add_confused_effects(&mut page, answer, own);
    }
    Ok(page.end())
}

/// Adds verdict, warnings, findings and prediction error.
fn add_answer(page: &mut Page, answer: &Answer) {
    page.section(verdict(answer.verdict));
    for what in &answer.warnings {
        page.paragraph(&format!("Warning: {}.", warning(what)));
    }
    for finding in &answer.findings {
        page.paragraph(&finding.statement);
    }
    for difference in unstated(answer) {
        page.paragraph(&format!(
            "Robot {}, {}: {}.",
            difference.robot, difference.channel, difference.shape
        ));
    }
    let [before, after] = [answer.held_out.nrmse_before, answer.held_out.nrmse_after];
    let named = |finding: &Finding| finding.effect != "unknown";
    page.paragraph(&if !answer.findings.iter().any(named) {
        let without = match answer.verdict {
            Verdict::Unexplained => " Physics outside the catalogue cannot be predicted.",
            _ => "",
        };
        format!(
            "Prediction error over 5 s: {before:.2} sensor standard deviations (noise alone: 1).{without}"
        )
    } else {
        format!(
            "Prediction error over 5 s, in sensor standard deviations: nominal model {before:.2}, improved \
             model {after:.2} (noise alone: 1)."
        )
    });
}

fn add_parameters(page: &mut Page, answer: &Answer, figures: &Figures) {
    let own = answer
        .findings
        .iter()
        .filter(|finding| finding.robot == figures.robot);
    let rows = own.flat_map(|f| f.parameters.iter().map(|p| parameter_row(f, p)));
    let rows: Vec<Vec<String>> = rows.collect();
    if !rows.is_empty() {
        page.subsection("Parameters");
        page.table(
            &[
                "effect",
                "parameter",
                "unit",
                "nominal",
                "estimate",
                "95 % interval",
            ],
            &rows,
        );
    }
}

fn parameter_row(finding: &Finding, parameter: &ParameterEstimate) -> Vec<String> {
    let or_none = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), format_number);
    let interval = match parameter.ci95 {
        Some([low, high]) if low.is_finite() && high.is_finite() => {
            format!("{} to {}", format_number(low), format_number(high))
        }
        Some(_) => "not determined by this recording".to_owned(),
        None => "–".to_owned(),
    };
    let estimate = parameter
        .text
        .clone()
        .unwrap_or_else(|| or_none(parameter.estimate));
    vec![
        finding.effect.clone(),
        parameter.name.clone(),
        parameter.unit.clone(),
        or_none(parameter.nominal),
        estimate,
        interval,
    ]
}

fn add_prediction_errors(page: &mut Page, answer: &Answer, figures: &Figures) {
    page.subsection("Prediction error over 5 s by channel");
    page.paragraph(
        "The initial state of each window is fitted to its first half second; the rest is simulated from \
         the commands. Root mean square in sensor standard deviations; noise alone gives 1.",
    );
    let own = answer
        .held_out
        .channels
        .iter()
        .filter(|c| c.robot == figures.robot);
    let rows = own.map(|c| {
        vec![
            c.channel.clone(),
            format_number(c.nrmse_before),
            format_number(c.nrmse_after),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    page.table(&["channel", NOMINAL.0, FOUND.0], &rows);
}

fn add_limits(page: &mut Page, figures: &Figures) {
    page.subsection("Effects ruled out, with limits on their size");
    page.paragraph(
        "No other effect of the catalogue is larger than its limit. At the limit, and with the findings in \
         the model, its parameter would differ from zero by 4.5 standard deviations; for a threshold, the \
         limit is the smallest tested value that the recording contradicts. Effects that could still be \
         large come first. The limits account for sensor noise, not for other errors of the simulation.",
    );
    let known = figures
        .limits
        .iter()
        .filter_map(|limit| Some((limit, limit.size?)));
    let rows = known.map(|(limit, size)| {
        vec![
            effect_of(limit),
            limit.parameter.to_owned(),
            ruled_out(limit, size),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    page.table(&["effect", "parameter", "ruled out"], &rows);
}

fn effect_of(limit: &Limit) -> String {
    match limit.word {
        Some(word) => format!("{} ({word})", limit.effect),
        None => limit.effect.to_owned(),
    }
}

fn ruled_out(limit: &Limit, size: f64) -> String {
    let unit = if limit.unit == "1" {
        String::new()
    } else {
        format!(" {}", limit.unit)
    };
    let size = format_number(size);
    match limit.seen {
        Seen::Above => format!("above {size}{unit}"),
        Seen::Below => format!("below {size}{unit}"),
        Seen::Around(nothing) => {
            format!("further than {size}{unit} from {}", format_number(nothing))
        }
    }
}

fn add_confused_effects(page: &mut Page, answer: &Answer, figures: &Figures) {
    page.subsection("Effects that cannot be told apart, and an experiment that distinguishes them");
    let mut rows: Vec<Vec<String>> = Vec::new();
    for finding in answer.findings.iter().filter(|f| f.robot == figures.robot) {
        for other in &finding.confused_with {
            let both = format!("{} or {other}", finding.effect);
            rows.push(vec![both, manoeuvre(&[&finding.effect, other])]);
        }
    }
    let mut unobservable: Vec<String> = Vec::new();
    for limit in figures.limits.iter().filter(|limit| limit.size.is_none()) {
        let effect = effect_of(limit);
        if !unobservable.contains(&effect) {
            rows.push(vec![
                format!("{effect}: not observable in this recording"),
                manoeuvre(&[limit.effect]),
            ]);
            unobservable.push(effect);
        }
    }
    if rows.is_empty() {
        page.paragraph("None: the recording distinguishes each finding from every other effect of the catalogue, and would have shown every other effect.");
    } else {
        page.table(&["effects", "experiment"], &rows);
    }
    page.paragraph(
        "Pushes and friction patches are searched for only if no other effect reduces the residuals to noise. \
         Link delays can be found only with the recordings of both robots.",
    );
}
