//! A chart: marks that stretch with the page, words that keep their size.

use maud::{Markup, PreEscaped, html};

use super::ink::Ink;
use super::outline::{ACROSS, UP, area, outline, trail};
use super::scale::Scale;

/// A chart in the making. Words beside it are HTML, marks in it SVG.
#[derive(Debug, Clone)]
pub struct Frame {
    x: Scale,
    y: Scale,
    /// Height (pixels), or none where both axes have one scale.
    height_px: Option<u32>,
    x_unit: Option<String>,
    y_unit: String,
    description: String,
    columns: usize,
    back: String,
    marks: String,
    spans: Vec<(Option<usize>, [f64; 2])>,
    labels: Vec<ChartLabel>,
    is_linked: bool,
    has_y: bool,
}

/// Words in a chart.
#[derive(Debug, Clone)]
struct ChartLabel {
    at: [f64; 2],
    text: String,
    ink: Ink,
    class: &'static str,
}

impl Frame {
    /// An empty chart of this height.
    pub fn new(x: Scale, y: Scale, height_px: u32, description: impl Into<String>) -> Self {
        Self {
            x,
            y,
            height_px: Some(height_px),
            x_unit: None,
            y_unit: String::new(),
            description: description.into(),
            columns: 900,
            back: String::new(),
            marks: String::new(),
            spans: Vec::new(),
            labels: Vec::new(),
            is_linked: false,
            has_y: true,
        }
    }

    /// A chart of the floor: both axes (m) have the same scale.
    pub fn floor(x: Scale, y: Scale, description: impl Into<String>) -> Self {
        Self {
            height_px: None,
            ..Self::new(x, y, 0, description)
        }
    }

    /// Shows ticks below, the last one with this unit.
    #[must_use]
    pub fn x_axis(mut self, unit: impl Into<String>) -> Self {
        self.x_unit = Some(unit.into());
        self
    }

    /// The unit that the uppermost tick carries.
    #[must_use]
    pub fn y_unit(mut self, unit: impl Into<String>) -> Self {
        self.y_unit = unit.into();
        self
    }

    /// How many columns of its lines are told apart.
    #[must_use]
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = columns;
        self
    }

    /// A line over sorted horizontal values; steps longer than `gap` break it.
    #[must_use]
    pub fn line(mut self, ink: Ink, points: &[(f64, f64)], gap: f64) -> Self {
        let path = outline(points, &self.x, &self.y, self.columns, gap);
        self.stroke(ink.stroke(), &path);
        self
    }

    /// A path whose points follow each other in any direction.
    #[must_use]
    pub fn trail(mut self, ink: Ink, points: &[(f64, f64)]) -> Self {
        let path = trail(points, &self.x, &self.y);
        self.stroke(ink.stroke(), &path);
        self
    }

    /// The area between two lines over the same horizontal values.
    #[must_use]
    pub fn band(mut self, low: &[(f64, f64)], high: &[(f64, f64)]) -> Self {
        let path = area(low, high, &self.x, &self.y);
        self.back
            .push_str(&format!("<path class=\"band\" d=\"{path}\"/>"));
        self
    }

    /// The area between a line and 0.
    #[must_use]
    pub fn filled(mut self, ink: Ink, points: &[(f64, f64)]) -> Self {
        let zero: Vec<(f64, f64)> = points.iter().map(|(x, _)| (*x, 0.0)).collect();
        let path = area(&zero, points, &self.x, &self.y);
        let class = ink.stroke();
        self.back
            .push_str(&format!("<path class=\"fill {class}\" d=\"{path}\"/>"));
        self
    }

    /// What a sensor alone does: a band of this half width around 0.
    #[must_use]
    pub fn noise(mut self, half: f64) -> Self {
        let [from, to] = [half, -half].map(|v| self.up(v).clamp(0.0, UP));
        self.back.push_str(&format!(
            "<path class=\"nz\" d=\"M0 {from:.0}H{ACROSS}V{to:.0}H0z\"/>"
        ));
        self
    }

    /// Dots of this width (pixels).
    #[must_use]
    pub fn dots(mut self, ink: Ink, points: &[(f64, f64)], width_px: f64) -> Self {
        let mut path = String::new();
        for (x, y) in points
            .iter()
            .filter(|(x, y)| x.is_finite() && y.is_finite())
        {
            path.push_str(&format!("M{:.0} {:.0}h0", self.across(*x), self.up(*y)));
        }
        if !path.is_empty() {
            self.marks.push_str(&format!(
                "<path class=\"{} pt\" style=\"stroke-width:{width_px}px\" d=\"{path}\"/>",
                ink.stroke()
            ));
        }
        self
    }

    /// Upright strokes over the whole height from `share` of it down, one for each place.
    #[must_use]
    pub fn strokes(mut self, ink: Ink, places: &[f64], share: f64) -> Self {
        let mut path = String::new();
        let mut last = f64::NEG_INFINITY;
        for place in places {
            // two strokes within a column are one
            let at = (self.x.place(*place) * 1100.0).floor();
            if at > last {
                last = at;
                path.push_str(&format!(
                    "M{:.0} {:.0}V{UP}",
                    self.across(*place),
                    (1.0 - share) * UP
                ));
            }
        }
        self.stroke(ink.stroke(), &path);
        self
    }

    /// A line across at this value.
    #[must_use]
    pub fn level(mut self, ink: Ink, value: f64) -> Self {
        let up = self.up(value);
        self.stroke(ink.stroke(), &format!("M0 {up:.0}H{ACROSS}"));
        self
    }

    /// Shades a span of the horizontal axis; spans with a number are shown when that number is chosen.
    #[must_use]
    pub fn span(mut self, number: Option<usize>, span: [f64; 2]) -> Self {
        self.spans.push((number, span));
        self
    }

    /// Words at a place, to its right.
    #[must_use]
    pub fn label(mut self, ink: Ink, at: [f64; 2], text: impl Into<String>) -> Self {
        let place = self.x.place(at[0]);
        let class = if place > 0.75 { "dl r" } else { "dl" };
        self.labels.push(ChartLabel {
            at,
            text: text.into(),
            ink,
            class,
        });
        self
    }

    /// The chart without ticks beside it.
    pub fn markup_without_y(mut self) -> Markup {
        self.has_y = false;
        self.markup()
    }

    /// The chart follows the cursor of its group.
    #[must_use]
    pub(super) fn linked(mut self) -> Self {
        self.is_linked = true;
        self
    }

    /// Where its horizontal axis begins and ends.
    pub(super) fn domain(&self) -> [f64; 2] {
        [self.x.low, self.x.high]
    }

    fn across(&self, x: f64) -> f64 {
        (self.x.place(x) * ACROSS).clamp(-ACROSS, 2.0 * ACROSS)
    }

    fn up(&self, y: f64) -> f64 {
        ((1.0 - self.y.place(y)) * UP).clamp(-2.0 * UP, 3.0 * UP)
    }

    fn stroke(&mut self, class: &str, path: &str) {
        if !path.is_empty() {
            self.marks
                .push_str(&format!("<path class=\"{class}\" d=\"{path}\"/>"));
        }
    }

    fn y_ticks(&self) -> Vec<(f64, String)> {
        if self.has_y {
            self.y.ticks()
        } else {
            Vec::new()
        }
    }

    fn grid(&self) -> String {
        let mut grid = String::new();
        for (value, _) in self.y_ticks() {
            let class = if value == 0.0 { "z" } else { "g" };
            grid.push_str(&format!(
                "<path class=\"{class}\" d=\"M0 {:.0}H{ACROSS}\"/>",
                self.up(value)
            ));
        }
        for (value, _) in self.x.ticks() {
            let class = if value == 0.0 && self.height_px.is_none() {
                "g"
            } else {
                "g gx"
            };
            grid.push_str(&format!(
                "<path class=\"{class}\" d=\"M{:.0} 0V{UP}\"/>",
                self.across(value)
            ));
        }
        grid
    }

    /// The chart.
    pub fn markup(&self) -> Markup {
        let style = match self.height_px {
            Some(height) => format!("--h:{height}px"),
            None => format!(
                "height:auto;aspect-ratio:{:.4}",
                (self.x.high - self.x.low) / (self.y.high - self.y.low)
            ),
        };
        let class = if self.height_px.is_some() {
            "fr"
        } else {
            "fr floor"
        };
        html! {
            div class=(class) style=(style) role="img" aria-label=(self.description) data-t[self.is_linked] {
                @for (number, span) in &self.spans {
                    i class="iv" data-f=[*number] style=(self.span_style(*span)) {}
                }
                svg viewBox=(Self::view_box()) preserveAspectRatio="none" aria-hidden="true" { (PreEscaped(self.drawn())) }
                (self.words())
                @if self.is_linked { span class="cur" {} }
            }
        }
    }

    fn span_style(&self, span: [f64; 2]) -> String {
        let [from, to] = span.map(|value| self.x.place(value).clamp(0.0, 1.0));
        format!("--l:{from:.4};--w:{:.4}", (to - from).max(0.001))
    }

    /// Ticks of the vertical axis: place between 0 and 1, and words.
    pub(super) fn words_up(&self) -> Vec<(f64, String)> {
        let ticks = self.y_ticks().into_iter();
        worded(
            ticks
                .map(|(value, text)| (self.y.place(value), text))
                .collect(),
            &self.y_unit,
        )
    }

    /// Ticks of the horizontal axis, if it has any.
    pub(super) fn words_across(&self) -> Vec<(f64, String)> {
        let Some(unit) = &self.x_unit else {
            return Vec::new();
        };
        let ticks = self.x.ticks().into_iter();
        worded(
            ticks
                .map(|(value, text)| (self.x.place(value), text))
                .collect(),
            unit,
        )
    }

    /// Grid and marks.
    pub(super) fn drawn(&self) -> String {
        [self.grid().as_str(), &self.back, &self.marks].concat()
    }

    /// What the marks are drawn in.
    pub(super) fn view_box() -> String {
        format!("0 0 {ACROSS} {UP}")
    }

    /// Its height at a width (pixels).
    pub(super) fn height_for(&self, width_px: f64) -> f64 {
        let ratio = (self.y.high - self.y.low) / (self.x.high - self.x.low);
        self.height_px.map_or(width_px * ratio, f64::from)
    }

    fn words(&self) -> Markup {
        html! {
            @for (share, text) in self.words_up() {
                span class="yt" style=(format!("top:{:.1}%", 100.0 * (1.0 - share))) { (text) }
            }
            @for (share, text) in self.words_across() {
                span class="xt" style=(format!("left:{:.1}%", 100.0 * share)) { (text) }
            }
            @for label in &self.labels {
                span class=(format!("{} halo {}", label.class, label.ink.words()))
                    style=(format!("left:{:.1}%;top:{:.1}%", 100.0 * self.x.place(label.at[0]),
                        (100.0 * (1.0 - self.y.place(label.at[1]))).clamp(0.0, 92.0))) { (label.text) }
            }
        }
    }
}

/// Ticks of which the last one carries the unit.
fn worded(mut ticks: Vec<(f64, String)>, unit: &str) -> Vec<(f64, String)> {
    if let Some((_, last)) = ticks.last_mut() {
        *last = super::small::with_unit(last, unit);
    }
    ticks
}
