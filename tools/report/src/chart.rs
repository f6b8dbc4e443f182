//! Lines over axes.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::legend::{height_px, legend};
use crate::line::{Line, Mark};
use crate::range::{label, range};
use crate::{DrawError, FONT_PX, PictureError, RIGHT_PX, WIDTH};

/// Left of the plot: the axis' numbers and what they mean (pixels).
const LEFT_PX: u32 = 84;
/// Height without the legend (pixels).
const HEIGHT_PX: u32 = 360;

/// Lines over two axes.
#[derive(Debug, Clone)]
pub struct Chart {
    x: String,
    y: String,
    lines: Vec<Line>,
    bands: Vec<(f64, f64)>,
}

impl Chart {
    /// A chart without lines, with what its axes mean, such as `t (s)`.
    pub fn new(x: impl Into<String>, y: impl Into<String>) -> Self {
        Self {
            x: x.into(),
            y: y.into(),
            lines: Vec::new(),
            bands: Vec::new(),
        }
    }

    /// Adds a line.
    #[must_use]
    pub fn line(mut self, line: Line) -> Self {
        self.lines.push(line);
        self
    }

    /// Adds lines.
    #[must_use]
    pub fn lines(mut self, lines: impl IntoIterator<Item = Line>) -> Self {
        self.lines.extend(lines);
        self
    }

    /// Shades the plot from one x to another, behind the lines; say in the caption what it means.
    #[must_use]
    pub fn band(mut self, from: f64, to: f64) -> Self {
        self.bands.push((from, to));
        self
    }

    /// The chart as SVG text.
    ///
    /// # Errors
    /// What the drawing library refuses.
    pub fn svg(&self) -> Result<String, PictureError> {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = range(points().map(|p| p.0));
        let y = range(points().map(|p| p.1));
        let drawing = Drawing {
            axes: [&self.x, &self.y],
            ranges: [x, y],
            height_px: HEIGHT_PX,
            lines: &self.lines,
            bands: &self.bands,
        };
        Ok(drawing.svg()?)
    }
}

/// Lines over axes whose ranges are known.
pub(crate) struct Drawing<'a> {
    pub(crate) axes: [&'a str; 2],
    pub(crate) ranges: [std::ops::Range<f64>; 2],
    pub(crate) height_px: u32,
    pub(crate) lines: &'a [Line],
    pub(crate) bands: &'a [(f64, f64)],
}

/// Size of the plot itself when the whole without the legend is so high (pixels).
pub(crate) fn plot_px(height_px: u32) -> [u32; 2] {
    [WIDTH - LEFT_PX - 12 - RIGHT_PX, height_px - 44 - 2 * 12]
}

type Plot<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Drawing<'_> {
    pub(crate) fn svg(&self) -> Result<String, DrawError> {
        let mut svg = String::new();
        {
            let height = self.height_px + height_px(self.lines, LEFT_PX);
            let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
            area.fill(&WHITE)?;
            let below = legend(&area, self.lines, LEFT_PX)?;
            let [x, y] = self.ranges.clone();
            let (x_label, y_label) = (label(&x), label(&y));
            let mut chart = ChartBuilder::on(&below)
                .margin(12)
                .margin_right(RIGHT_PX)
                .x_label_area_size(44)
                .y_label_area_size(LEFT_PX)
                .build_cartesian_2d(x, y)?;
            let [x, y] = self.axes;
            chart
                .configure_mesh()
                .light_line_style(TRANSPARENT)
                .label_style(("sans-serif", FONT_PX))
                .x_label_formatter(&x_label)
                .y_label_formatter(&y_label)
                .x_desc(x)
                .y_desc(y)
                .draw()?;
            self.draw_bands(&mut chart)?;
            for (i, line) in self.lines.iter().enumerate() {
                draw_line(&mut chart, line, line.shade(i))?;
            }
            area.present()?;
        }
        Ok(svg)
    }

    fn draw_bands(&self, chart: &mut Plot<'_, '_>) -> Result<(), DrawError> {
        let [x, y] = &self.ranges;
        for (from, to) in self.bands {
            let corners = [(from.max(x.start), y.start), (to.min(x.end), y.end)];
            let grey = BLACK.mix(0.12).filled();
            chart.draw_series([Rectangle::new(corners, grey)])?;
        }
        Ok(())
    }
}

fn draw_line(chart: &mut Plot<'_, '_>, line: &Line, colour: RGBColor) -> Result<(), DrawError> {
    let style = colour.stroke_width(2);
    for piece in line.pieces() {
        match line.mark {
            Mark::Solid => chart.draw_series(LineSeries::new(piece, style))?,
            Mark::Dashed => chart.draw_series(DashedLineSeries::new(piece, 6, 4, style))?,
            Mark::Dots => {
                let dots = piece.into_iter();
                chart.draw_series(dots.map(|dot| Circle::new(dot, 2, colour.filled())))?
            }
        };
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_axes_names_and_bands() {
        let chart = Chart::new("t (s)", "x (m)")
            .line(Line::new("one", [(0.0, 0.0), (1.0, 2.0)]))
            .line(Line::new("two", [(0.0, 1.0), (1.0, 1.0)]).dashed())
            .line(Line::new("three", [(0.5, 1.0)]).dots())
            .band(0.2, 0.4);
        let svg = chart.svg().unwrap();
        for text in ["t (s)", "x (m)", "one", "two", "three"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("opacity=\"0.12\""));
    }

    #[test]
    fn a_chart_of_nothing_is_empty_axes() {
        assert!(
            Chart::new("t (s)", "x (m)")
                .svg()
                .unwrap()
                .contains("t (s)")
        );
    }
}
