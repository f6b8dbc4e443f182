//! What is at work when.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::range::{label, range};
use crate::{COLOURS, DrawError, FONT_PX, PictureError, WIDTH, width_px};

const ROW_PX: u32 = 26;
const GAP_PX: u32 = 10;

/// What is at work when: a row of bars for each thing, over one axis.
#[derive(Debug, Clone)]
pub struct Timeline {
    x: String,
    rows: Vec<Row>,
}

/// A row of a [`Timeline`].
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Left of the bars.
    pub name: String,
    /// From and to.
    pub spans: Vec<(f64, f64)>,
    /// Right of the plot, such as a value with its unit; may be empty.
    pub note: String,
}

impl Timeline {
    /// A time-line whose axis means `x`, such as `t (s)`, with rows from the top down.
    pub fn new(x: impl Into<String>, rows: impl IntoIterator<Item = Row>) -> Self {
        Self {
            x: x.into(),
            rows: rows.into_iter().collect(),
        }
    }

    /// The time-line as SVG text.
    ///
    /// # Errors
    /// What the drawing library refuses.
    pub fn svg(&self) -> Result<String, PictureError> {
        Ok(self.draw()?)
    }

    fn draw(&self) -> Result<String, DrawError> {
        let widest = |of: fn(&Row) -> &str| {
            let widths = self.rows.iter().map(|row| width_px(of(row)));
            widths.max().unwrap_or(0) + GAP_PX
        };
        let (names, notes) = (widest(|row| &row.name), widest(|row| &row.note));
        let ends = self.rows.iter().flat_map(|row| &row.spans);
        let span = range(ends.flat_map(|(from, to)| [*from, *to]));
        let x_label = label(&span);
        let rows = u32::try_from(self.rows.len()).unwrap_or(1).max(1);
        let mut svg = String::new();
        {
            let height = rows * ROW_PX + 64;
            let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
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
            for (i, row) in self.rows.iter().enumerate() {
                let bottom = f64::from(rows) - 1.0 - i as f64;
                let (low, high) = (bottom + 0.15, bottom + 0.85);
                let bar = |&(from, to): &(f64, f64)| {
                    Rectangle::new([(from, low), (to, high)], COLOURS[0].filled())
                };
                // So that a span without length is seen.
                let edge = |&(from, _): &(f64, f64)| {
                    PathElement::new([(from, low), (from, high)], COLOURS[0])
                };
                chart.draw_series(row.spans.iter().map(bar))?;
                chart.draw_series(row.spans.iter().map(edge))?;
            }
            let (across, down) = chart.plotting_area().get_pixel_range();
            for (row, i) in self.rows.iter().zip(0_i32..) {
                let y =
                    down.start + (2 * i + 1) * (down.end - down.start) / (2 * rows.cast_signed());
                let text = |side| {
                    let font = ("sans-serif", FONT_PX).into_font().color(&BLACK);
                    font.pos(Pos::new(side, VPos::Center))
                };
                area.draw_text(&row.name, &text(HPos::Right), (across.start - 8, y))?;
                area.draw_text(&row.note, &text(HPos::Left), (across.end + 8, y))?;
            }
            area.present()?;
        }
        Ok(svg)
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
