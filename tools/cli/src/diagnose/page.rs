//! Report page of a diagnosis: the answer first, then the figures behind it.

use slipstream_diagnose::{
    Against, Answer, Figures, Finding, Limit, MissingForce, ParameterEstimate, Paths, Residuals,
    Seen, Verdict, manoeuvre,
};
use slipstream_report::{Chart, Line, Page, PictureError, Row, Timeline, Track};

use super::points::{kept, level, means};
use super::words::{number, verdict, warning};
use crate::study::command_line;

/// Names and colours of the lines.
const NOMINAL: (&str, usize) = ("nominal model", 1);
const FOUND: (&str, usize) = ("improved model", 0);
const CAMERA: (&str, usize) = ("camera", 5);

/// Root mean square (standard deviations) below which residuals are mostly noise and drawn as dots.
const NOISE_RMS: f64 = 3.0;

/// Ratio of the residuals before and after from which on those after get a figure of their own.
const ENLARGE_RATIO: f64 = 4.0;

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
            let nothing = if found(own) { "" } else { ": no finding" };
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

fn add_residuals(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    page.subsection("Residuals before and after");
    page.paragraph(
        "Simulated minus measured, in sensor standard deviations, over the windows of the fit (5 s each, \
         with a free initial state). Noise stays within about ±3.",
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
    // Noise drawn as a line would fill the figure.
    let nominal = if same && before < NOISE_RMS {
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
    if !same && before > ENLARGE_RATIO * after {
        let line = Line::new(FOUND.0, kept(&residuals.after))
            .dots()
            .colour(FOUND.1);
        let chart = Chart::new("t (s)", axis).line(line);
        page.figure(
            &chart.svg()?,
            &format!("{channel}{run}: residuals of the improved model, enlarged."),
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
    page.subsection("When each finding acts");
    let spans: Vec<(f64, f64)> = figures
        .spans_s
        .iter()
        .map(|[from, to]| (*from, *to))
        .collect();
    rows.push(row_of("recorded", &spans));
    page.figure(
        &Timeline::new("t (s)", rows).svg()?,
        "Intervals in which each finding acts, and their total length.",
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
    page.subsection("Missing force");
    page.paragraph(
        "The force that, added to the model in every interval of 50 ms, makes it follow the measurements. \
         It is estimated without assuming a cause, and regularised towards zero where the measurements \
         do not determine it. For a robot whose wheels follow their commands exactly it is a motion \
         instead. Curves over time are means over 0.25 s without outliers.",
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
            .line(Line::new("mean, nominal model", means(&against.before)).colour(NOMINAL.1));
    } else if against.curve.is_empty() {
        chart = chart
            .line(dots(NOMINAL.0, &against.before, 4))
            .line(Line::new("mean, nominal model", means(&against.before)).colour(NOMINAL.1))
            .line(
                Line::new("mean, improved model", means(&against.after))
                    .dashed()
                    .colour(FOUND.1),
            );
    } else {
        let curve = Line::new("finding", against.curve.iter().copied());
        let curve = curve.colour(NOMINAL.1);
        chart =
            chart
                .line(dots("missing force", &against.before, 4))
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
        page.subsection(&format!("Path{}", of_run(figures, path.run)));
        page.figure(
            &track(path).svg()?,
            "Windows of 5 s: the initial state is fitted to the first half second, the rest is simulated \
             from the commands.",
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
                "95 % interval",
            ],
            &rows,
        );
    }
}

fn parameter_row(finding: &Finding, parameter: &ParameterEstimate) -> Vec<String> {
    let or_none = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
    let between = match parameter.ci95 {
        Some([low, high]) if low.is_finite() && high.is_finite() => {
            format!("{} to {}", number(low), number(high))
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
            number(c.nrmse_before),
            number(c.nrmse_after),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    page.table(&["channel", NOMINAL.0, FOUND.0], &rows);
}

fn add_limits(page: &mut Page, figures: &Figures) {
    page.subsection("Effects ruled out, and down to which size");
    page.paragraph(
        "No other effect of the catalogue is larger than this. At this size, its parameter would differ \
         from zero by 4.5 standard deviations beside the findings; for thresholds it is the smallest \
         tried value that the recording refutes. Effects that could still be large come first. The \
         limits account for sensor noise, not for other errors of the simulation.",
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
    page.subsection("Effects that cannot be told apart, and the experiment that would");
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
                format!("{effect}: not observable here"),
                manoeuvre(&[limit.effect]),
            ]);
            blind.push(effect);
        }
    }
    if rows.is_empty() {
        page.paragraph("None: each finding differs from every other effect of the catalogue, and every other effect would have been observed.");
    } else {
        page.table(&["effects", "experiment"], &rows);
    }
    page.paragraph(
        "Pushes and friction patches are searched for only where no other effect brings the residuals to \
         noise. Link delays need the recordings of both robots.",
    );
}
