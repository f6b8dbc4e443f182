//! Rows of charts over one time axis, with one cursor, zoom, and intervals that a button chooses.

use maud::{Markup, PreEscaped, html};

use super::frame::Frame;
use super::ink::Ink;
use super::points::Way;
use super::scale::Scale;

/// Instants that the cursor knows.
const INSTANTS: usize = 600;

/// Rows over one time axis.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    id: String,
    rows: Vec<Row>,
    choices: Vec<(usize, String)>,
    begins_at_s: Option<f64>,
    floor: Option<(Frame, Vec<Dot>)>,
}

/// One chart with its title and what the cursor reads off it.
#[derive(Debug, Clone)]
pub struct Row {
    title: String,
    unit: String,
    frame: Frame,
    read: Vec<CursorReading>,
    legend: Vec<(Ink, String)>,
}

/// A line that the cursor reads.
#[derive(Debug, Clone)]
struct CursorReading {
    ink: Ink,
    name: String,
    points: Vec<(f64, f64)>,
    digits: usize,
}

/// A dot on the floor that follows the cursor.
#[derive(Debug, Clone)]
struct Dot {
    ink: Ink,
    /// Time (s), and place in shares of the frame.
    points: Vec<(f64, [f64; 2])>,
}

impl Row {
    /// A row; the chart's horizontal axis is that of all others.
    pub fn new(title: impl Into<String>, unit: impl Into<String>, frame: Frame) -> Self {
        Self {
            title: title.into(),
            unit: unit.into(),
            frame: frame.linked(),
            read: Vec::new(),
            legend: Vec::new(),
        }
    }

    /// What the cursor reads: a name, its points over time, and how many digits count.
    #[must_use]
    pub fn reads(
        mut self,
        ink: Ink,
        name: impl Into<String>,
        points: &[(f64, f64)],
        digits: usize,
    ) -> Self {
        self.read.push(CursorReading {
            ink,
            name: name.into(),
            points: points.to_vec(),
            digits,
        });
        self
    }

    /// Words beside the title, with a stroke in their colour.
    #[must_use]
    pub fn legend(mut self, ink: Ink, text: impl Into<String>) -> Self {
        self.legend.push((ink, text.into()));
        self
    }
}

impl Rows {
    /// No rows yet; `id` is unique on the page.
    pub fn new(id: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            ..Self::default()
        }
    }

    /// Adds a row.
    #[must_use]
    pub fn row(mut self, row: Row) -> Self {
        self.rows.push(row);
        self
    }

    /// A button that shades the spans of this number.
    #[must_use]
    pub fn choice(mut self, number: usize, text: impl Into<String>) -> Self {
        self.choices.push((number, text.into()));
        self
    }

    /// Where the cursor stands before it is moved (s).
    #[must_use]
    pub fn cursor_at(mut self, t_s: f64) -> Self {
        self.begins_at_s = Some(t_s);
        self
    }

    /// A chart of the floor beside the rows, on which dots follow the cursor: time (s), x and y (m).
    #[must_use]
    pub fn floor(
        mut self,
        frame: Frame,
        [x, y]: [Scale; 2],
        dots: impl IntoIterator<Item = (Ink, Way)>,
    ) -> Self {
        let dots = dots.into_iter().map(|(ink, points)| Dot {
            ink,
            points: points
                .iter()
                .map(|(t_s, px, py)| (*t_s, [x.place(*px), 1.0 - y.place(*py)]))
                .collect(),
        });
        self.floor = Some((frame, dots.collect()));
        self
    }

    /// Whether there is nothing to show.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The rows.
    pub fn markup(&self) -> Markup {
        let chosen = self.choices.first().map(|(number, _)| *number);
        html! {
            div class=(if self.floor.is_some() { "evg beside" } else { "evg" })
                data-cursor=(format!("{}-data", self.id)) data-sel=[chosen] data-at=[self.begins_at_s] {
                @if self.choices.len() > 1 { (self.buttons()) }
                @if let Some((frame, dots)) = &self.floor {
                    figure class="pathf" {
                        div class="row-h" { b { "Path" } span class="muted" { "m" } span class="v" data-v="t" {} }
                        div class="fl-w" {
                            (frame.markup())
                            @for (place, dot) in dots.iter().enumerate() {
                                i class=(format!("dot {}", dot.ink.stroke())) data-p=(format!("p{place}x,p{place}y")) {}
                            }
                        }
                    }
                }
                div class="rows" {
                    @for (place, row) in self.rows.iter().enumerate() { (self.row_markup(place, row)) }
                    input class="scrub" type="range" min="0" max="1" value="0" aria-label="Time of the cursor";
                    p class="zoom noprint" {
                        button class="btn" data-zoom="in" { "Zoom in" }
                        button class="btn" data-zoom="out" { "Zoom out" }
                        button class="btn" data-zoom="all" { "Whole" }
                        span class="muted small" {
                            "Drag over a chart to enlarge a span, double click for the whole; arrow keys move the cursor."
                        }
                    }
                }
                script type="application/json" id=(format!("{}-data", self.id)) { (PreEscaped(self.data())) }
            }
        }
    }

    fn buttons(&self) -> Markup {
        html! {
            div class="lanes noprint" role="group" aria-label="Shade when a finding is at work" {
                @for (place, (number, text)) in self.choices.iter().enumerate() {
                    button class="btn lane" data-shade=(number) aria-pressed=(place == 0) {
                        span class="n" { (number) } (text)
                    }
                }
            }
        }
    }

    fn row_markup(&self, place: usize, row: &Row) -> Markup {
        html! {
            div class="row-h" {
                b { (row.title) }
                @if !row.unit.is_empty() { span class="muted" { (row.unit) } }
                @for (ink, text) in &row.legend {
                    span class=(ink.words()) { i class=(format!("kl {}", ink.stroke())) {} (text) }
                }
                span class="v" {
                    @for (number, reading) in row.read.iter().enumerate() {
                        b class=(reading.ink.words()) data-v=(format!("r{place}_{number}"))
                            data-d=(reading.digits) {} " " (reading.name)
                        @if number + 1 < row.read.len() { ", " }
                    }
                    @if place == 0 && self.floor.is_none() { " at " span data-v="t" {} }
                }
            }
            (row.frame.markup())
        }
    }

    /// What the cursor knows, as JSON.
    fn data(&self) -> String {
        let [low, high] = self
            .rows
            .first()
            .map_or([0.0, 1.0], |row| row.frame.domain());
        let times = self.instants();
        let mut out = format!(
            "{{\"lo\":{low},\"hi\":{high},\"t\":[{}]",
            list(times.iter().map(|t| fixed_plain(*t, 3)))
        );
        for (place, row) in self.rows.iter().enumerate() {
            for (number, reading) in row.read.iter().enumerate() {
                let values = times.iter().map(|t| {
                    at(&reading.points, *t, |p| p.0)
                        .map_or("null".to_owned(), |p| fixed_plain(p.1, reading.digits))
                });
                out.push_str(&format!(",\"r{place}_{number}\":[{}]", list(values)));
            }
        }
        let dots = self.floor.iter().flat_map(|(_, dots)| dots).enumerate();
        for (place, dot) in dots {
            for (axis, name) in ["x", "y"].iter().enumerate() {
                let values = times.iter().map(|t| {
                    at(&dot.points, *t, |p| p.0)
                        .map_or("null".to_owned(), |p| fixed_plain(100.0 * p.1[axis], 2))
                });
                out.push_str(&format!(",\"p{place}{name}\":[{}]", list(values)));
            }
        }
        out.push('}');
        out
    }

    /// At most [`INSTANTS`] times of the first line, or of the dots.
    fn instants(&self) -> Vec<f64> {
        let lines = self.rows.iter().flat_map(|row| &row.read);
        let longest = lines.max_by_key(|reading| reading.points.len());
        let times: Vec<f64> = longest.map_or_else(Vec::new, |reading| {
            let finite = reading.points.iter().filter(|p| p.1.is_finite());
            finite.map(|p| p.0).collect()
        });
        let stride = times.len().div_ceil(INSTANTS).max(1);
        let mut instants: Vec<f64> = times.into_iter().step_by(stride).collect();
        if let Some(t_s) = self.begins_at_s {
            let place = instants.partition_point(|own| *own < t_s);
            if instants.get(place) != Some(&t_s) {
                instants.insert(place, t_s);
            }
        }
        instants
    }
}

/// The point nearest to a time, if one is near: within a second.
fn at<P>(points: &[P], t_s: f64, time: fn(&P) -> f64) -> Option<&P> {
    let next = points.partition_point(|p| time(p) < t_s);
    let near = [next.checked_sub(1), Some(next)];
    let near = near.into_iter().flatten().filter_map(|i| points.get(i));
    let near = near.filter(|p| (time(p) - t_s).abs() < 1.0);
    near.min_by(|a, b| (time(a) - t_s).abs().total_cmp(&(time(b) - t_s).abs()))
}

fn list(values: impl Iterator<Item = String>) -> String {
    values.collect::<Vec<_>>().join(",")
}

/// A number as JSON has it.
fn fixed_plain(value: f64, digits: usize) -> String {
    if value.is_finite() {
        format!("{value:.digits$}")
    } else {
        "null".to_owned()
    }
}
