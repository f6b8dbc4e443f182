//! A timeline: intervals of several things as bars over one time axis.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::{limits, tick_label};
use crate::error::{DrawError, PictureError};
use crate::plot::Axes;
use crate::style::{COLOURS, FONT_PX, WIDTH_PX, text_width_px};

/// Height of a row (pixels).
const ROW_PX: u32 = 26;
/// Height below the rows, for tick labels and the axis title, with margins (pixels).
const AXIS_PX: u32 = 64;
/// Space beside a name or a note (pixels).
const GAP_PX: u32 = 10;

/// Intervals as bars, one row for each thing, over one time axis.
#[derive(Debug, Clone)]
pub struct Timeline {
    x: String,
    rows: Vec<Row>,
}

/// A row of a [`Timeline`].
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Name, left of the bars.
    pub name: String,
    /// Start and end of each bar, in the unit of the axis.
    pub spans: Vec<(f64, f64)>,
    /// Text right of the plot, such as a value with its unit; may be empty.
    pub note: String,
}

impl Timeline {
    /// A timeline with axis title `x`, such as `t (s)`, and rows from the top down.
    pub fn new(x: impl Into<String>, rows: impl IntoIterator<Item = Row>) -> Self {
        Self {
            x: x.into(),
            rows: rows.into_iter().collect(),
        }
    }

    /// The timeline as SVG text.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn svg(&self) -> Result<String, PictureError> {
        Ok(self.draw()?)
    }

    fn draw(&self) -> Result<String, DrawError> {
        let widest = |of: fn(&Row) -> &str| {
            let widths = self.rows.iter().map(|row| text_width_px(of(row)));
            widths.max().unwrap_or(0) + GAP_PX
        };
        let (names, notes) = (widest(|row| &row.name), widest(|row| &row.note));
        let ends = self.rows.iter().flat_map(|row| &row.spans);
        let span = limits(ends.flat_map(|(from, to)| [*from, *to]));
        let x_label = tick_label(&span);
        let rows = u32::try_from(self.rows.len()).unwrap_or(1).max(1);
        let mut svg = String::new();
        {
            let height = rows * ROW_PX + AXIS_PX;
            let area = SVGBackend::with_string(&mut svg, (WIDTH_PX, height)).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .margin(8)
                .margin_left(names + GAP_PX)
                .margin_right(notes + GAP_PX)
                .x_label_area_size(44)
                .build_cartesian_2d(span, 0.0..f64::from(rows))?;
            let mut mesh = chart.configure_mesh();
            mesh.disable_y_mesh().disable_y_axis();
            mesh.light_line_style(TRANSPARENT)
                .label_style(("sans-serif", FONT_PX))
                .x_labels(8)
                .x_label_formatter(&x_label)
                .x_desc(self.x.as_str())
                .draw()?;
            self.draw_bars(&mut chart, rows)?;
            self.draw_texts(&area, rows, chart.plotting_area().get_pixel_range())?;
            area.present()?;
        }
        Ok(svg)
    }

    fn draw_bars(&self, chart: &mut Axes<'_, '_>, rows: u32) -> Result<(), DrawError> {
        for (i, row) in self.rows.iter().enumerate() {
            let bottom = f64::from(rows) - 1.0 - i as f64;
            let (low, high) = (bottom + 0.15, bottom + 0.85);
            let bar = |&(from, to): &(f64, f64)| {
                Rectangle::new([(from, low), (to, high)], COLOURS[0].filled())
            };
            // Keeps an interval of zero length visible.
            let edge =
                |&(from, _): &(f64, f64)| PathElement::new([(from, low), (from, high)], COLOURS[0]);
            chart.draw_series(row.spans.iter().map(bar))?;
            chart.draw_series(row.spans.iter().map(edge))?;
        }
        Ok(())
    }

    /// Writes names and notes beside the rows; `x_px` and `y_px` are the plotting area in pixels.
    fn draw_texts(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        rows: u32,
        (x_px, y_px): (Range<i32>, Range<i32>),
    ) -> Result<(), DrawError> {
        for (row, i) in self.rows.iter().zip(0_i32..) {
            let y = y_px.start + (2 * i + 1) * (y_px.end - y_px.start) / (2 * rows.cast_signed());
            let text = |side| {
                let font = ("sans-serif", FONT_PX).into_font().color(&BLACK);
                font.pos(Pos::new(side, VPos::Center))
            };
            area.draw_text(&row.name, &text(HPos::Right), (x_px.start - 8, y))?;
            area.draw_text(&row.note, &text(HPos::Left), (x_px.end + 8, y))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_notes_stand_beside_the_bars() {
        let row = |name: &str, spans: &[(f64, f64)], note: &str| Row {
            name: name.to_owned(),
            spans: spans.to_vec(),
            note: note.to_owned(),
        };
        let rows = [
            row("wheel slip", &[(5.0, 5.6), (8.1, 8.1)], "0.6 s"),
            row("push", &[], "never"),
        ];
        let svg = Timeline::new("t (s)", rows).svg().unwrap();
        for text in ["t (s)", "wheel slip", "0.6 s", "push", "never"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(Timeline::new("t (s)", []).svg().is_ok());
    }
}
