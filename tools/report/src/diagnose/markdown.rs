//! The findings as Markdown, for a pull request.

use std::fmt::Write as _;

use super::diagnosis::Diagnosis;
use super::errors::errors;
use super::findings::taken;
use super::first_screen::chip;
use crate::effect_words::{all_shown, name};
use crate::parts::{fixed, short, with_unit};

/// The findings as Markdown, for a pull request.
pub(super) fn markdown(diagnosis: &Diagnosis<'_>) -> String {
    let answer = diagnosis.answer;
    let (_, _, chip) = chip(answer);
    let mut text = format!(
        "**slipstream diagnose** `{}`: {}. {}",
        diagnosis.subject,
        chip.to_lowercase(),
        diagnosis.sentence()
    );
    let errors: Vec<String> = errors(answer)
        .iter()
        .map(|own| {
            let [before, after] = own.ends.map(|end| with_unit(&short(end), own.unit));
            format!("{after}{} (before: {before})", own.whose())
        })
        .collect();
    if !errors.is_empty() {
        let _ = write!(
            text,
            " A {} s prediction misses by {}.",
            fixed(answer.held_out.horizon_s, 0),
            errors.join(", ")
        );
    }
    text.push_str("\n\n| left out of the model | was | is (95 %) | takes away | what to do |\n|---|---|---|---|---|\n");
    for (_, _, finding) in diagnosis.numbered() {
        let model = diagnosis.model(&finding.robot);
        let rows = all_shown(finding, model.as_ref());
        let was = rows
            .iter()
            .map(|row| row.was_words().unwrap_or_else(|| "–".to_owned()));
        let was: Vec<String> = was.collect();
        let is = rows.iter().map(|row| {
            format!(
                "{} {} ({})",
                row.label,
                row.is_words(),
                row.interval_words()
            )
        });
        let is: Vec<String> = is.collect();
        let _ = writeln!(
            text,
            "| {} {} `{}` | {} | {} | {} | {} |",
            finding.robot,
            name(&finding.effect).to_lowercase(),
            finding.effect,
            was.join(", "),
            is.join(", "),
            taken(answer, finding).join(", "),
            finding.actions.join("; ")
        );
    }
    text
}
