//! A diagnosis as a page: the answer in words first, then the figures that show it.

use slipstream_diagnose::{
    Against, Answer, Figures, Finding, Limit, MissingForce, ParameterEstimate, Paths, Residuals,
    Seen, Verdict, manoeuvre,
};
use slipstream_report::{Chart, Line, Page, PictureError, Row, Timeline, Track};

use super::points::{kept, level, means};
use super::words::{number, verdict, warning};
use crate::study::command_line;

/// What the lines are called, and their colours.
const NOMINAL: (&str, usize) = ("nominal model", 1);
const FOUND: (&str, usize) = ("with what was found", 0);
const CAMERA: (&str, usize) = ("camera", 5);

/// Root mean square (standard deviations) below which a line is mostly noise.
const NOISY: f64 = 3.0;

/// From how much smaller residuals on (before over after) those after stand in a figure of their own.
const OWN_FIGURE: f64 = 4.0;

/// The whole page.
pub(super) fn page(
    name: &str,
    answer: &Answer,
    figures: &[Figures],
) -> Result<String, PictureError> {
    let mut page = Page::new(&format!("Diagnosis of {name}"), &command_line());
    add_answer(&mut page, answer);
    let found = |own: &Figures| answer.findings.iter().any(|f| f.robot == own.robot);
    // robots with findings first
    let (with, without): (Vec<&Figures>, Vec<&Figures>) =
        figures.iter().partition(|own| found(own));
    for own in with.into_iter().chain(without) {
        if figures.len() > 1 {
            let nothing = if found(own) { "" } else { ": nothing found" };
            page.section(&format!("Robot {}{nothing}", own.robot));
        }
        add_residuals(&mut page, own)?;
        add_timeline(&mut page, answer, own)?;
        add_forces(&mut page, own)?;
        add_paths(&mut page, own)?;
        add_parameters(&mut page, answer, own);
        add_held_out(&mut page, answer, own);
        add_limits(&mut page, own);
        add_look_alikes(&mut page, answer, own);
    }
    Ok(page.end())
}

/// The first screen.
fn add_answer(page: &mut Page, answer: &Answer) {
    page.section(verdict(answer.verdict));
    for what in &answer.warnings {
        page.paragraph(&format!("Warning: {}.", warning(what)));
    }
    for finding in &answer.findings {
        page.paragraph(&finding.statement);
    }
    let said = |shape: &str| {
        answer
            .findings
            .iter()
            .any(|f| f.shape.as_deref() == Some(shape))
    };
    for left in answer.unexplained.iter().filter(|left| !said(&left.shape)) {
        page.paragraph(&format!(
            "Robot {}, {}: {}.",
            left.robot, left.channel, left.shape
        ));
    }
    let [before, after] = [answer.held_out.nrmse_before, answer.held_out.nrmse_after];
    let named = |finding: &Finding| finding.effect != "unknown";
    page.paragraph(&if !answer.findings.iter().any(named) {
        let without = match answer.verdict {
            Verdict::Unexplained => " What is outside of the catalogue does not predict.",
            _ => "",
        };
        format!(
            "Prediction error over 5 s: {before:.2} standard deviations of the sensors. Noise alone \
             gives 1.{without}"
        )
    } else {
        format!(
            "Prediction error over 5 s, in standard deviations of the sensors: {before:.2} by the \
             nominal model → {after:.2} with what was found. Noise alone gives 1."
        )
    });
}

fn add_residuals(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    page.subsection("Residuals before and after");
    page.paragraph(
        "Simulated minus measured, in standard deviations of the sensor, in the windows of the fit \
         (5 s each, with a free initial state). Noise stays within about ±3.",
    );
    for residuals in &figures.residuals {
        add_channel(page, residuals, &of_run(figures, residuals.run))?;
    }
    Ok(())
}

/// Which recording, where there are several.
fn of_run(figures: &Figures, run: usize) -> String {
    if figures.spans_s.len() > 1 {
        format!(", recording {}", run + 1)
    } else {
        String::new()
    }
}

fn add_channel(page: &mut Page, residuals: &Residuals, run: &str) -> Result<(), PictureError> {
    let channel = residuals.channel;
    let [before, after] = [level(&residuals.before), level(&residuals.after)];
    let axis = format!("{channel} (standard deviations)");
    let same = residuals.after.is_empty();
    let nominal = Line::new(NOMINAL.0, residuals.before.iter().copied()).colour(NOMINAL.1);
    // a line through noise would fill the figure
    let nominal = if same && before < NOISY {
        nominal.dots()
    } else {
        nominal
    };
    let mut chart = Chart::new("t (s)", axis.clone()).line(nominal);
    if !same {
        chart = chart.line(Line::new(FOUND.0, residuals.after.iter().copied()).colour(FOUND.1));
    }
    let caption = if same {
        format!("{channel}{run}: root mean square {}.", number(before))
    } else {
        let [before, after] = [before, after].map(number);
        format!("{channel}{run}: root mean square {before} before, {after} after.")
    };
    page.figure(&chart.svg()?, &caption);
    if !same && before > OWN_FIGURE * after {
        let line = Line::new(FOUND.0, kept(&residuals.after))
            .dots()
            .colour(FOUND.1);
        let chart = Chart::new("t (s)", axis).line(line);
        page.figure(
            &chart.svg()?,
            &format!("{channel}{run}: what is left, enlarged."),
        );
    }
    Ok(())
}

fn add_timeline(page: &mut Page, answer: &Answer, figures: &Figures) -> Result<(), PictureError> {
    let own = |finding: &&Finding| finding.robot == figures.robot;
    let own: Vec<&Finding> = answer.findings.iter().filter(own).collect();
    let mut rows: Vec<Row> = own.iter().enumerate().map(|(i, _)| row(&own, i)).collect();
    if rows.is_empty() {
        return Ok(());
    }
    page.subsection("When it is at work");
    let spans: Vec<(f64, f64)> = figures
        .spans_s
        .iter()
        .map(|[from, to]| (*from, *to))
        .collect();
    rows.push(row_of("recorded", &spans));
    page.figure(
        &Timeline::new("t (s)", rows).svg()?,
        "Intervals in which each finding acts, with their sum. What always acts fills the recording.",
    );
    Ok(())
}

/// The row of the `i`th finding; those of one name are counted.
fn row(findings: &[&Finding], i: usize) -> Row {
    let finding = findings[i];
    let like = |other: &&&Finding| other.effect == finding.effect;
    let name = if findings.iter().filter(like).count() > 1 {
        format!(
            "{} {}",
            finding.effect,
            findings[..=i].iter().filter(like).count()
        )
    } else {
        finding.effect.clone()
    };
    let spans: Vec<(f64, f64)> = finding
        .place
        .intervals_s
        .iter()
        .map(|[a, b]| (*a, *b))
        .collect();
    row_of(&name, &spans)
}

fn row_of(name: &str, spans: &[(f64, f64)]) -> Row {
    let sum: f64 = spans.iter().map(|(from, to)| to - from).sum();
    Row {
        name: name.to_owned(),
        spans: spans.to_vec(),
        note: format!("{} s", number(sum)),
    }
}

fn add_forces(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    page.subsection("What is missing");
    page.paragraph(
        "The force that would have to be added to the model at every moment (50 ms each) for it to \
         follow the measurements, without any idea of the cause; kept near zero where the \
         measurements say nothing of it. Wheels that turn as they are told feel no force: then it is a \
         motion. Over time: its mean over a quarter of a second, without the extremes.",
    );
    for force in &figures.forces {
        add_over_time(page, force, &of_run(figures, force.run))?;
    }
    for against in &figures.against {
        add_against(page, against)?;
    }
    Ok(())
}

fn add_over_time(page: &mut Page, force: &MissingForce, run: &str) -> Result<(), PictureError> {
    let line = |(name, colour): (&str, usize), points: &[(f64, f64)]| {
        Line::new(name, points.iter().copied()).colour(colour)
    };
    let mut chart = Chart::new("t (s)", force.quantity.clone()).line(line(NOMINAL, &force.before));
    if !force.after.is_empty() {
        chart = chart.line(line(FOUND, &force.after));
    }
    page.figure(
        &chart.svg()?,
        &format!("Over time{run}: {}.", force.quantity),
    );
    Ok(())
}

fn add_against(page: &mut Page, against: &Against) -> Result<(), PictureError> {
    let mut chart = Chart::new(against.variable.clone(), against.quantity.clone());
    let dots = |name: &str, points: &[(f64, f64)], colour: usize| {
        Line::new(name, kept(points)).dots().colour(colour)
    };
    if against.curve.is_empty() && against.after.is_empty() {
        chart = chart
            .line(dots("measured", &against.before, 4))
            .line(Line::new("its mean", means(&against.before)).colour(NOMINAL.1));
    } else if against.curve.is_empty() {
        chart = chart
            .line(dots(NOMINAL.0, &against.before, 4))
            .line(Line::new("its mean", means(&against.before)).colour(NOMINAL.1))
            .line(
                Line::new("mean with what was found", means(&against.after))
                    .dashed()
                    .colour(FOUND.1),
            );
    } else {
        let curve = Line::new("what was found", against.curve.iter().copied());
        let curve = curve.colour(NOMINAL.1);
        chart = chart
            .line(dots("missing at each moment", &against.before, 4))
            .line(if against.is_function {
                curve
            } else {
                curve.dots()
            });
    }
    let (effect, variable) = (&against.effect, &against.variable);
    page.figure(
        &chart.svg()?,
        &format!("{effect}: {} against {variable}.", against.quantity),
    );
    Ok(())
}

fn add_paths(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    for path in &figures.paths {
        page.subsection(&format!(
            "The path against the camera{}",
            of_run(figures, path.run)
        ));
        page.figure(
            &track(path).svg()?,
            "In pieces of 5 s: the start of each is fitted to its first half second, the rest is \
             simulated from the commands alone.",
        );
    }
    Ok(())
}

fn track(path: &Paths) -> Track {
    let line = |(name, colour): (&str, usize), points: &[(f64, f64)]| {
        Line::new(name, points.iter().copied()).colour(colour)
    };
    let track = Track::new()
        .line(line(CAMERA, &path.camera).dots())
        .line(line(NOMINAL, &path.before).dashed());
    if path.after.is_empty() {
        track
    } else {
        track.line(line(FOUND, &path.after))
    }
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
                "95 % between",
            ],
            &rows,
        );
    }
}

fn parameter_row(finding: &Finding, parameter: &ParameterEstimate) -> Vec<String> {
    let or_none = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
    let between = match parameter.ci95 {
        Some([low, high]) if low.is_finite() && high.is_finite() => {
            format!("{} and {}", number(low), number(high))
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
        between,
    ]
}

fn add_held_out(page: &mut Page, answer: &Answer, figures: &Figures) {
    page.subsection("Prediction over 5 s, channel by channel");
    page.paragraph(
        "Each window's start is fitted to its first half second; the rest, which that fit never \
         saw, is simulated from the commands. Root mean square in standard deviations of the \
         sensor; noise alone gives 1.",
    );
    let own = answer
        .held_out
        .channels
        .iter()
        .filter(|c| c.robot == figures.robot);
    let rows = own.map(|c| {
        vec![
            c.channel.clone(),
            number(c.nrmse_before),
            number(c.nrmse_after),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    page.table(&["channel", NOMINAL.0, FOUND.0], &rows);
}

fn add_limits(page: &mut Page, figures: &Figures) {
    page.subsection("What was ruled out, and down to what size");
    page.paragraph(
        "No other effect of the catalogue is larger than this: at this size its parameter would be \
         4.5 standard deviations away from nothing beside what was found (thresholds: the smallest \
         of those tried that the recording refutes). What could still be large comes first, by the \
         smallest size at which the catalogue expects it. This is what noise allows; how well a \
         simulation can know a robot is another question.",
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
    let size = number(size);
    match limit.seen {
        Seen::Above => format!("above {size}{unit}"),
        Seen::Below => format!("below {size}{unit}"),
        Seen::Around(nothing) => format!("further than {size}{unit} from {}", number(nothing)),
    }
}

fn add_look_alikes(page: &mut Page, answer: &Answer, figures: &Figures) {
    page.subsection("What cannot be told apart here, and what would tell");
    let mut rows: Vec<Vec<String>> = Vec::new();
    for finding in answer.findings.iter().filter(|f| f.robot == figures.robot) {
        for twin in &finding.confused_with {
            let both = format!("{} or {twin}", finding.effect);
            rows.push(vec![both, manoeuvre(&[&finding.effect, twin])]);
        }
    }
    let mut blind: Vec<String> = Vec::new();
    for limit in figures.limits.iter().filter(|limit| limit.size.is_none()) {
        let effect = effect_of(limit);
        if !blind.contains(&effect) {
            rows.push(vec![
                format!("{effect}: not shown here"),
                manoeuvre(&[limit.effect]),
            ]);
            blind.push(effect);
        }
    }
    if rows.is_empty() {
        page.paragraph("Nothing: each finding differs from everything else in the catalogue, and each other effect would have shown.");
    } else {
        page.table(&["what", "what would tell"], &rows);
    }
    page.paragraph(
        "A push and a patch of other friction are looked for where nothing else brings the \
         residuals to noise; delays of links need the recordings of two robots.",
    );
}
