//! The page, in Markdown.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use slipstream_diagnose::{Answer, ParameterEstimate, Prediction, in_digits};
use toml::Value;

use crate::agreement::{Agreement, Estimate, agree};
use crate::picture::Picture;
use crate::study::Study;
use crate::transfer::Transfer;

const HEAD: &str = "\
# Recordings of real robots

Made by `just real`, not typed. Every robot was recorded by other people on a real machine; the model is
made from published figures alone (wheel radius, track, counts per turn). The recordings stay outside of
this repository.

Prediction error: windows of 5 s, the state at a window's start fitted to its first half second, the
rest simulated from the commands, or from the wheels where there are none. Root mean square over all
windows, in metres and degrees, against the independent reference. The parameters of a finding were
fitted to up to 24 of the same windows; what the last table says comes from data that they never saw.
Findings are added in the order in which they were found, with the values of the whole. Where there is
no pose, the heading is the gyro's integral over the window.
";

/// The page as it grows.
pub(crate) struct Page {
    pictures: BTreeMap<String, Vec<Picture>>,
}

impl Page {
    pub(crate) fn new() -> Self {
        let pictures = BTreeMap::new();
        Self { pictures }
    }

    pub(crate) fn picture(&mut self, study: &Study<'_>, picture: Picture) {
        let own = self.pictures.entry(study.recording.name.clone());
        own.or_default().push(picture);
    }

    /// The whole page.
    pub(crate) fn text(
        &self,
        studies: &[Study<'_>],
        agreements: &[Agreement],
        transfers: &[Transfer],
    ) -> String {
        let mut text = HEAD.to_owned();
        text += &overview(studies);
        for study in studies {
            text += &self.of_study(study);
        }
        text += &of_agreements(agreements);
        text += &of_transfers(transfers);
        text
    }

    fn of_study(&self, study: &Study<'_>) -> String {
        let recording = study.recording;
        let mut text = format!("\n## {}\n\n", recording.name);
        let note = |key: &str| recording.notes.get(key).and_then(Value::as_str);
        let kind = note("kind").unwrap_or("unknown");
        let licence = note("licence").unwrap_or("unstated");
        text += &format!("{}.\nOrigin: {}.\n", kind.trim(), recording.origin.trim());
        text += &format!("Licence: {licence}.\n\n");
        text += &steps(study);
        text += &findings(study);
        text += &held_out(&study.found.answer);
        for left in &study.found.answer.unexplained {
            let _ = writeln!(
                text,
                "\nUnexplained, {}, {}: {}.",
                left.robot, left.channel, left.shape
            );
        }
        for picture in self.pictures.get(&recording.name).into_iter().flatten() {
            let _ = writeln!(
                text,
                "\n![{}, the first minute]({})",
                picture.robot, picture.file
            );
        }
        text
    }
}

fn overview(studies: &[Study<'_>]) -> String {
    let mut text = String::from(
        "\n| recording | robot | position before (m) | after | | heading before (°) | after | |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for study in studies {
        for robot in &study.recording.robots {
            if let Some([before, after]) = study.ends(&robot.name) {
                let name = &study.recording.name;
                let _ = writeln!(
                    text,
                    "| {name} | {} | {} |",
                    robot.name,
                    both(before, after)
                );
            }
        }
    }
    text
}

/// Position and heading before and after, and by which factor each is better.
fn both(before: &Prediction, after: &Prediction) -> String {
    format!(
        "{} | {} | {} | {} | {} | {}",
        metres(before),
        metres(after),
        factor(before.position_m, after.position_m),
        degrees(before),
        degrees(after),
        factor(before.heading_rad, after.heading_rad)
    )
}

fn factor(before: Option<f64>, after: Option<f64>) -> String {
    match (before, after) {
        (Some(before), Some(after)) if after > before => {
            format!("**worse, × {:.1}**", after / before)
        }
        (Some(before), Some(after)) => format!("÷ {:.1}", before / after),
        _ => String::new(),
    }
}

fn metres(prediction: &Prediction) -> String {
    let own = prediction.position_m;
    own.map_or_else(|| "–".to_owned(), |m| format!("{m:.3}"))
}

fn degrees(prediction: &Prediction) -> String {
    let own = prediction.heading_rad.map(f64::to_degrees);
    own.map_or_else(|| "–".to_owned(), |degrees| format!("{degrees:.2}"))
}

fn steps(study: &Study<'_>) -> String {
    let mut text =
        String::from("| robot | model | position (m) | heading (°) |\n| --- | --- | --- | --- |\n");
    for step in &study.steps {
        let model = step.added.as_ref();
        let model = model.map_or("nominal".to_owned(), |effect| format!("+ `{effect}`"));
        let (robot, own) = (&step.robot, &step.prediction);
        let _ = writeln!(
            text,
            "| {robot} | {model} | {} | {} |",
            metres(own),
            degrees(own)
        );
    }
    text
}

fn findings(study: &Study<'_>) -> String {
    let findings = &study.found.answer.findings;
    if findings.is_empty() {
        return "\nNothing was found.\n".to_owned();
    }
    let mut text = String::from(
        "\n| robot | finding | value, 95 % between | cannot be told from |\n| --- | --- | --- | --- |\n",
    );
    for finding in findings {
        let values: Vec<String> = finding.parameters.iter().map(value).collect();
        let shape = finding.shape.clone().unwrap_or_default();
        let _ = writeln!(
            text,
            "| {} | `{}` | {}{shape} | {} |",
            finding.robot,
            finding.effect,
            values.join("<br>"),
            finding.confused_with.join(", ")
        );
    }
    text
}

/// By what predictions are better where something that no `robot.toml` can say is a law beside the rest.
fn held_out(answer: &Answer) -> String {
    let strange = answer.findings.iter().filter(|f| f.effect == "unknown");
    let mut robots: Vec<&str> = strange.map(|f| f.robot.as_str()).collect();
    robots.dedup();
    let mut text = String::new();
    for robot in robots {
        let ratio = |names: &[&str]| {
            let own = answer.held_out.channels.iter();
            let own = own.filter(|c| c.robot == robot && names.contains(&c.channel.as_str()));
            let [before, after] = own.fold([0.0; 2], |[before, after], c| {
                [
                    before + c.nrmse_before.powi(2),
                    after + c.nrmse_after.powi(2),
                ]
            });
            // what was not measured has no error
            (before > 0.0).then(|| factor(Some(before.sqrt()), Some(after.sqrt())))
        };
        let ratios = ratio(&["pose_x", "pose_y"]).zip(ratio(&["pose_yaw"]));
        if let Some((position, heading)) = ratios {
            let _ = writeln!(
                text,
                "\n{robot}, with `unknown` as a law, all of it fitted to every other window and judged by \
                 the rest: position {position}, heading {heading}."
            );
        }
    }
    text
}

fn value(parameter: &ParameterEstimate) -> String {
    let name = &parameter.name;
    let unit = match parameter.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    match (parameter.estimate.zip(parameter.ci95), &parameter.text) {
        (Some(estimate), _) => format!("{name} {}{unit}", with_interval(estimate)),
        (None, Some(word)) => format!("{name} {word}"),
        (None, None) => name.clone(),
    }
}

fn with_interval((estimate, interval): Estimate) -> String {
    let [estimate, low, high] = in_digits(estimate, interval);
    format!("{estimate} ({low} … {high})")
}

fn of_agreements(agreements: &[Agreement]) -> String {
    let mut text = String::from(
        "\n## Do runs agree?\n\nRuns of one machine, or of machines of one kind, each diagnosed by \
         itself. Agree: every run found it, and the intervals of 95 % have a value in common.\n",
    );
    for agreement in agreements {
        let runs = agreement.runs.join(" | ");
        let rule = "--- | ".repeat(agreement.runs.len());
        let _ = writeln!(text, "\n| effect | parameter | {runs} | agree |");
        let _ = writeln!(text, "| --- | --- | {rule}--- |");
        for ((effect, parameter), row) in &agreement.rows {
            let cells: Vec<String> = row
                .iter()
                .map(|one| one.map_or_else(|| "–".to_owned(), with_interval))
                .collect();
            let agrees = if agree(row) { "yes" } else { "no" };
            let cells = cells.join(" | ");
            let _ = writeln!(text, "| `{effect}` | {parameter} | {cells} | {agrees} |");
        }
    }
    text
}

fn of_transfers(transfers: &[Transfer]) -> String {
    let mut text = String::from(
        "\n## Data that the model never saw\n\nThe model improved on one run predicts another.\n\n\
         | found on | effects | predicted | position before (m) | after | | heading before (°) | after | |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for transfer in transfers {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} |",
            transfer.fitted_on,
            transfer.effects.join(", "),
            transfer.tried_on,
            both(&transfer.before, &transfer.after)
        );
    }
    text
}
