//! Figures of a diagnosis: residuals, intervals of the findings, missing force, path.

use slipstream_diagnose::{Against, Answer, Figures, Finding, MissingForce, Paths, Residuals};
use slipstream_report::{Chart, Line, Page, PictureError, Row, Timeline, Track};

use super::points::{binned_means, finite_points, rms};
use super::text::format_number;

/// Name and colour of the lines for the nominal model.
pub(super) const NOMINAL: (&str, usize) = ("nominal model", 1);
/// Name and colour of the lines for the improved model.
pub(super) const FOUND: (&str, usize) = ("improved model", 0);
/// Name and colour of the positions that the camera measured.
const CAMERA: (&str, usize) = ("camera", 5);

/// Residuals with a root mean square (standard deviations) below this are mostly noise and drawn as dots.
const NOISE_RMS: f64 = 3.0;

/// The residuals of the improved model get a second, enlarged figure if they are smaller by this factor.
const ENLARGE_RATIO: f64 = 4.0;

/// A line through points, with name and colour of a kind.
fn line((name, colour): (&str, usize), points: &[(f64, f64)]) -> Line {
    Line::new(name, points.iter().copied()).colour(colour)
}

pub(super) fn add_residuals(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    page.subsection("Residuals before and after");
    page.paragraph(
        "Simulated minus measured, in sensor standard deviations, over the windows of the fit (5 s each, \
         with free initial states). Noise stays within about ±3.",
    );
    for residuals in &figures.residuals {
        add_channel(page, residuals, &recording_label(figures, residuals.run))?;
    }
    Ok(())
}

/// Number of the recording for captions, if there are several.
fn recording_label(figures: &Figures, run: usize) -> String {
    if figures.spans_s.len() > 1 {
        format!(", recording {}", run + 1)
    } else {
        String::new()
    }
}

fn add_channel(page: &mut Page, residuals: &Residuals, run: &str) -> Result<(), PictureError> {
    let channel = residuals.channel;
    let [before, after] = [rms(&residuals.before), rms(&residuals.after)];
    let axis = format!("{channel} (standard deviations)");
    let unchanged = residuals.after.is_empty();
    let nominal = line(NOMINAL, &residuals.before);
    // A line through noise would fill the figure.
    let nominal = if unchanged && before < NOISE_RMS {
        nominal.dots()
    } else {
        nominal
    };
    let mut chart = Chart::new("t (s)", axis.clone()).line(nominal);
    if !unchanged {
        chart = chart.line(line(FOUND, &residuals.after));
    }
    let caption = if unchanged {
        format!(
            "{channel}{run}: root mean square {}.",
            format_number(before)
        )
    } else {
        let [before, after] = [before, after].map(format_number);
        format!("{channel}{run}: root mean square {before} before, {after} after.")
    };
    page.figure(&chart.svg()?, &caption);
    if !unchanged && before > ENLARGE_RATIO * after {
        let line = Line::new(FOUND.0, finite_points(&residuals.after))
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

pub(super) fn add_timeline(
    page: &mut Page,
    answer: &Answer,
    figures: &Figures,
) -> Result<(), PictureError> {
    let own = |finding: &&Finding| finding.robot == figures.robot;
    let own: Vec<&Finding> = answer.findings.iter().filter(own).collect();
    let mut rows: Vec<Row> = own
        .iter()
        .enumerate()
        .map(|(i, _)| finding_row(&own, i))
        .collect();
    if rows.is_empty() {
        return Ok(());
    }
    page.subsection("When each finding acts");
    let spans: Vec<(f64, f64)> = figures
        .spans_s
        .iter()
        .map(|[from, to]| (*from, *to))
        .collect();
    rows.push(timeline_row("recorded", &spans));
    page.figure(
        &Timeline::new("t (s)", rows).svg()?,
        "Intervals in which each finding acts, with their total length.",
    );
    Ok(())
}

/// Row of the `i`th finding. Findings of the same effect are numbered.
fn finding_row(findings: &[&Finding], i: usize) -> Row {
    let finding = findings[i];
    let same_effect = |other: &&&Finding| other.effect == finding.effect;
    let name = if findings.iter().filter(same_effect).count() > 1 {
        format!(
            "{} {}",
            finding.effect,
            findings[..=i].iter().filter(same_effect).count()
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
    timeline_row(&name, &spans)
}

fn timeline_row(name: &str, spans: &[(f64, f64)]) -> Row {
    let sum: f64 = spans.iter().map(|(from, to)| to - from).sum();
    Row {
        name: name.to_owned(),
        spans: spans.to_vec(),
        note: format!("{} s", format_number(sum)),
    }
}

pub(super) fn add_forces(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    page.subsection("Missing force");
    page.paragraph(
        "The force that, added to the model in every interval of 50 ms, makes it follow the measurements. \
         It is estimated without assuming a cause, and regularised towards zero where the measurements \
         do not determine it. For a robot whose wheels follow their commands exactly it is a motion \
         instead. Curves over time are means over 0.25 s without outliers.",
    );
    for force in &figures.forces {
        add_over_time(page, force, &recording_label(figures, force.run))?;
    }
    for against in &figures.against {
        add_against(page, against)?;
    }
    Ok(())
}

fn add_over_time(page: &mut Page, force: &MissingForce, run: &str) -> Result<(), PictureError> {
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
        Line::new(name, finite_points(points)).dots().colour(colour)
    };
    if against.curve.is_empty() && against.after.is_empty() {
        chart = chart.line(dots("measured", &against.before, 4)).line(
            Line::new("mean, nominal model", binned_means(&against.before)).colour(NOMINAL.1),
        );
    } else if against.curve.is_empty() {
        chart = chart
            .line(dots(NOMINAL.0, &against.before, 4))
            .line(Line::new("mean, nominal model", binned_means(&against.before)).colour(NOMINAL.1))
            .line(
                Line::new("mean, improved model", binned_means(&against.after))
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

pub(super) fn add_paths(page: &mut Page, figures: &Figures) -> Result<(), PictureError> {
    for path in &figures.paths {
        page.subsection(&format!("Path{}", recording_label(figures, path.run)));
        page.figure(
            &track(path).svg()?,
            "Windows of 5 s: the initial state is fitted to the first half second, the rest is simulated \
             from the commands.",
        );
    }
    Ok(())
}

fn track(path: &Paths) -> Track {
    let track = Track::new()
        .line(line(CAMERA, &path.camera).dots())
        .line(line(NOMINAL, &path.before).dashed());
    if path.after.is_empty() {
        track
    } else {
        track.line(line(FOUND, &path.after))
    }
}
