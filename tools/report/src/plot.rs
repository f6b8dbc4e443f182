//! Lines over axes of given limits: the drawing behind `Chart` and `Track`.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use crate::axis::tick_label;
use crate::error::DrawError;
use crate::legend::{height_px, legend};
use crate::line::{Line, LineStyle};
use crate::style::{FONT_PX, RIGHT_MARGIN_PX, WIDTH_PX};

/// Width left of the plot, for tick labels and the axis title (pixels).
const LEFT_PX: u32 = 84;
/// Height below the plot, for tick labels and the axis title (pixels).
const BELOW_PX: u32 = 44;
/// Margin on the other sides (pixels).
const MARGIN_PX: u32 = 12;

/// Lines over axes of given limits; pairs are (x, y).
pub(crate) struct Plot<'a> {
    /// Axis titles.
    pub(crate) titles: [&'a str; 2],
    pub(crate) limits: [std::ops::Range<f64>; 2],
    /// Height of the figure without its legend (pixels).
    pub(crate) height_px: u32,
    pub(crate) lines: &'a [Line],
    /// Shaded ranges of x.
    pub(crate) bands: &'a [(f64, f64)],
}

/// Width and height of the plotting area in a figure of this height without legend (pixels).
pub(crate) fn plotting_area_px(height_px: u32) -> [u32; 2] {
    [
        WIDTH_PX - LEFT_PX - MARGIN_PX - RIGHT_MARGIN_PX,
        height_px - BELOW_PX - 2 * MARGIN_PX,
    ]
}

pub(crate) type Axes<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Plot<'_> {
    /// The figure as SVG text.
    pub(crate) fn svg(&self) -> Result<String, DrawError> {
        let mut svg = String::new();
        {
            let height = self.height_px + height_px(self.lines, LEFT_PX);
            let area = SVGBackend::with_string(&mut svg, (WIDTH_PX, height)).into_drawing_area();
            area.fill(&WHITE)?;
            let below = legend(&area, self.lines, LEFT_PX)?;
            let [x, y] = self.limits.clone();
            let (x_label, y_label) = (tick_label(&x), tick_label(&y));
            let mut chart = ChartBuilder::on(&below)
                .margin(MARGIN_PX)
                .margin_right(RIGHT_MARGIN_PX)
                .x_label_area_size(BELOW_PX)
                .y_label_area_size(LEFT_PX)
                .build_cartesian_2d(x, y)?;
            let [x, y] = self.titles;
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
                draw_line(&mut chart, line, line.rgb(i))?;
            }
            area.present()?;
        }
        Ok(svg)
    }

    fn draw_bands(&self, chart: &mut Axes<'_, '_>) -> Result<(), DrawError> {
        let [x, y] = &self.limits;
        for (from, to) in self.bands {
            let corners = [(from.max(x.start), y.start), (to.min(x.end), y.end)];
            let grey = BLACK.mix(0.12).filled();
            chart.draw_series([Rectangle::new(corners, grey)])?;
        }
        Ok(())
    }
}

fn draw_line(chart: &mut Axes<'_, '_>, line: &Line, colour: RGBColor) -> Result<(), DrawError> {
    let style = colour.stroke_width(2);
    for piece in line.pieces() {
        match line.style {
            LineStyle::Solid => chart.draw_series(LineSeries::new(piece, style))?,
            LineStyle::Dashed => chart.draw_series(DashedLineSeries::new(piece, 6, 4, style))?,
            LineStyle::Dots => {
                let dots = piece.into_iter();
                chart.draw_series(dots.map(|dot| Circle::new(dot, 2, colour.filled())))?
            }
        };
    }
    Ok(())
}
