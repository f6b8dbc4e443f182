//! Where the error was over time and what is left of it, and where each finding is at work.

use maud::{Markup, html};
use slipstream_answer::{ErrorLine, Figures, Finding};

use super::cards;
use super::diagnosis::Diagnosis;
use crate::effect_words::name;
use crate::parts::{
    Frame, Ink, Points, Row, Rows, Scale, capital, columns_of, gap_of, short, shown_unit,
};

/// Share of a recording from which on a finding acts all the time.
const ALWAYS: f64 = 0.98;
/// Deviations of a sensor between which 95 % of its noise lies.
const NOISE: f64 = 1.96;
/// Findings that a button can shade, and spans of each at most.
const CHOICES: usize = 9;
const SHADED: usize = 200;
/// Height of a chart (pixels).
const HEIGHT_PX: u32 = 96;
/// Runs of one machine whose rows are open.
const OPEN: usize = 1;

/// Errors over time and a card for each finding.
pub(super) fn section(diagnosis: &Diagnosis<'_>, machines: &[&Figures]) -> Markup {
    let lines: usize = machines
        .iter()
        .map(|own| 2 * own.errors.len() + 2 * own.motion.len() + 2 * own.forces.len())
        .sum();
    let columns = columns_of(lines);
    let several = machines.len() > 1;
    html! {
        section id="evidence" aria-labelledby="h-evidence" {
            h2 id="h-evidence" { "Where the error was, and what is left" }
            p class="sub" { "The model starts afresh every 5 s and then runs on what drives the robot. Predicted minus "
                "measured, as seen from the robot." }
            @for (place, own) in machines.iter().enumerate() {
                @if several { h3 { (own.robot) } }
                (runs(diagnosis, own, place, columns))
            }
            (key(diagnosis, machines))
        }
        (cards::section(diagnosis, machines))
    }
}

/// What shades mean, of those that are drawn.
fn key(diagnosis: &Diagnosis<'_>, machines: &[&Figures]) -> Markup {
    let runs = || {
        let all = machines.iter();
        all.flat_map(|own| (0..own.spans_s.len()).map(move |run| (*own, run)))
    };
    let works = runs().any(|(own, run)| !at_work(diagnosis, own, run).is_empty());
    let noise = runs().any(|(own, run)| specs(own, run).iter().any(Spec::shows_noise));
    html! {
        @if works || noise {
            p class="key" {
                @if works { span { i class="k3" {} "where the chosen finding is at work" } }
                @if noise { span { i class="k4" {} "95 % of the sensor's own noise" } }
            }
        }
    }
}

/// The rows of each run of a machine; those of the worst run are open.
fn runs(diagnosis: &Diagnosis<'_>, own: &Figures, place: usize, columns: usize) -> Markup {
    let mut order: Vec<usize> = (0..own.spans_s.len()).collect();
    let loss = |run: usize| -> f64 {
        let lines = own.errors.iter().filter(|line| line.run == run);
        lines
            .map(|line| rms(&line.before) / line.deviation.max(1e-12))
            .fold(0.0, f64::max)
    };
    order.sort_by(|a, b| loss(*b).total_cmp(&loss(*a)));
    let several = order.len() > 1;
    let title = |run: usize| {
        own.runs
            .get(run)
            .cloned()
            .unwrap_or_else(|| format!("run {}", run + 1))
    };
    html! {
        @for (rank, run) in order.iter().enumerate() {
            @let rows = rows(diagnosis, own, place, *run, columns);
            @if rank < OPEN {
                @if several { p class="sub" { "Run " (title(*run)) ", the one that is furthest off." } }
                (rows)
            } @else {
                details { summary { "Run " (title(*run)) } (rows) }
            }
        }
    }
}

/// The rows of one run.
fn rows(
    diagnosis: &Diagnosis<'_>,
    own: &Figures,
    place: usize,
    run: usize,
    columns: usize,
) -> Markup {
    let [from, to] = own.spans_s[run];
    let x = Scale::new(from, to, 7);
    let chosen = at_work(diagnosis, own, run);
    let mut rows = Rows::new(format!("m{place}r{run}"));
    for (number, finding) in &chosen {
        let words = format!("{}: {}", name(&finding.effect), finding.place.condition);
        rows = rows.choice(*number, words);
    }
    let specs = specs(own, run);
    for (index, spec) in specs.iter().enumerate() {
        let mut frame = spec.frame(x).columns(columns);
        if index + 1 == specs.len() {
            frame = frame.x_axis("s");
        }
        for (number, finding) in &chosen {
            for span in finding.place.intervals_s.iter().take(SHADED) {
                frame = frame.span((chosen.len() > 1).then_some(*number), *span);
            }
        }
        for line in &spec.lines {
            frame = frame.line(line.ink, &line.points, gap_of(&line.points));
        }
        rows = rows.row(spec.row(frame));
    }
    html! { @if !rows.is_empty() { (rows.markup()) } }
}

/// Findings that are at work in a part of this run, with their numbers.
fn at_work<'a>(
    diagnosis: &'a Diagnosis<'_>,
    own: &Figures,
    run: usize,
) -> Vec<(usize, &'a Finding)> {
    let [from, to] = own.spans_s[run];
    let of_run = |name: &String| own.runs.get(run).is_none_or(|own| own == name);
    // the intervals of a finding are those of the first run for which it holds
    let is_here = |finding: &Finding| {
        let first = finding.runs.as_ref().map(|runs| runs.first());
        let in_run = first.map_or(run == 0, |first| first.is_some_and(of_run));
        finding.robot == own.robot && in_run
    };
    let in_part = |finding: &Finding| {
        let at_work: f64 = finding.place.intervals_s.iter().map(|[a, b]| b - a).sum();
        at_work > 0.0 && at_work < ALWAYS * (to - from)
    };
    let all = diagnosis.numbered().into_iter();
    all.filter(|(_, _, finding)| is_here(finding) && in_part(finding))
        .map(|(number, _, finding)| (number, finding))
        .take(CHOICES)
        .collect()
}

/// Every chart of one run.
fn specs(own: &Figures, run: usize) -> Vec<Spec> {
    let mut specs = motion(own, run);
    let errors = own.errors.iter().filter(|line| line.run == run);
    specs.extend(errors.map(error_row));
    let forces = own.forces.iter().filter(|force| force.run == run);
    specs.extend(forces.map(|force| Spec {
        title: capital(force.quantity),
        unit: force.unit,
        lines: pair(&force.before, &force.after, 1.0),
        noise: None,
        legend: Vec::new(),
    }));
    specs
}

/// One chart in the making.
struct Spec {
    title: String,
    unit: &'static str,
    lines: Vec<ChartLine>,
    noise: Option<f64>,
    legend: Vec<(Ink, String)>,
}

/// One line of a chart.
struct ChartLine {
    ink: Ink,
    name: &'static str,
    points: Points,
}

impl Spec {
    fn scale(&self) -> Scale {
        let all = self.lines.iter().flat_map(|line| &line.points);
        let y = Scale::around(all.map(|p| p.1), true, 3);
        if self.unit == "degrees" {
            y.of_degrees()
        } else {
            y
        }
    }

    /// Whether the sensor's noise is wide enough to be seen.
    fn shows_noise(&self) -> bool {
        let y = self.scale();
        let px = |noise: f64| 2.0 * noise / (y.high - y.low) * f64::from(HEIGHT_PX);
        self.noise.is_some_and(|noise| px(noise) >= 1.0)
    }

    fn frame(&self, x: Scale) -> Frame {
        let frame = Frame::new(x, self.scale(), HEIGHT_PX, self.described());
        match self.noise.filter(|_| self.shows_noise()) {
            Some(noise) => frame.noise(noise),
            None => frame,
        }
    }

    fn row(&self, frame: Frame) -> Row {
        let digits = self.scale().digits() + 1;
        let mut row = Row::new(self.title.clone(), self.unit, frame);
        for line in &self.lines {
            row = row.reads(line.ink, line.name, &line.points, digits);
        }
        for (ink, text) in &self.legend {
            row = row.legend(*ink, text.clone());
        }
        row
    }

    fn described(&self) -> String {
        let words: Vec<&str> = self.legend.iter().map(|(_, text)| text.as_str()).collect();
        format!(
            "{} over time, {}: {}",
            self.title,
            self.unit,
            words.join(", ")
        )
    }
}

fn pair(before: &[(f64, f64)], after: &[(f64, f64)], factor: f64) -> Vec<ChartLine> {
    let both = [
        (Ink::Before, "before", before),
        (Ink::After, "after", after),
    ];
    let there = both.into_iter().filter(|(_, _, points)| !points.is_empty());
    there
        .map(|(ink, name, points)| ChartLine {
            ink,
            name,
            points: points.iter().map(|(t, y)| (*t, factor * y)).collect(),
        })
        .collect()
}

fn motion(own: &Figures, run: usize) -> Vec<Spec> {
    let moves = own.motion.iter().filter(|motion| motion.run == run);
    moves
        .flat_map(|motion| {
            let degrees = motion.turn_rad_s.iter().map(|(t, w)| (*t, w.to_degrees()));
            let parts = [
                ("Speed", "m/s", motion.speed_m_s.clone()),
                ("Turn rate", "degrees/s", degrees.collect()),
            ];
            parts
                .into_iter()
                .filter(|(_, _, points)| !points.is_empty())
                .map(|(title, unit, points)| Spec {
                    title: title.to_owned(),
                    unit,
                    lines: vec![ChartLine {
                        ink: Ink::Context,
                        name: "",
                        points,
                    }],
                    noise: None,
                    legend: Vec::new(),
                })
        })
        .collect()
}

fn error_row(line: &ErrorLine) -> Spec {
    let (factor, unit) = match shown_unit(line.unit) {
        // titles stand before no number
        (factor, "°") => (factor, "degrees"),
        shown => shown,
    };
    let before = rms(&line.before) * factor;
    let title = match line.quantity {
        "wheel_right" => "Right wheel".to_owned(),
        "wheel_left" => "Left wheel".to_owned(),
        "imu_gz" => "Gyro".to_owned(),
        "imu_ax" => "Acceleration forward".to_owned(),
        "imu_ay" => "Acceleration sideways".to_owned(),
        "odometry_v" => "Odometry speed".to_owned(),
        "odometry_w" => "Odometry turn rate".to_owned(),
        other => capital(&other.replace('_', " ")),
    };
    let mut legend = vec![(Ink::Before, format!("before, rms {}", short(before)))];
    if !line.after.is_empty() {
        legend.push((
            Ink::After,
            format!("after, rms {}", short(rms(&line.after) * factor)),
        ));
    }
    Spec {
        title,
        unit,
        lines: pair(&line.before, &line.after, factor),
        noise: Some(NOISE * line.deviation * factor),
        legend,
    }
}

fn rms(points: &[(f64, f64)]) -> f64 {
    let (count, sum) = points
        .iter()
        .filter(|p| p.1.is_finite())
        .fold((0.0, 0.0), |(count, sum), p| (count + 1.0, sum + p.1 * p.1));
    f64::sqrt(sum / f64::max(count, 1.0))
}
