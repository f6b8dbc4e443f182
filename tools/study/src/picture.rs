//! Lines over axes, as SVG.

use plotters::prelude::*;

/// A line of a picture.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    /// For the legend.
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
    /// Dashed, so that black-and-white print tells it from the others.
    pub(crate) dashed: bool,
}

/// Colours that stay apart in print and for the colour-blind (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x33, 0x33, 0x33),
];

/// Draws lines over axes with these descriptions (with units).
pub(crate) fn picture(x: &str, y: &str, lines: &[Line]) -> Result<String, crate::StudyError> {
    draw(x, y, lines).map_err(|error| crate::StudyError::Picture(error.to_string()))
}

fn draw(x: &str, y: &str, lines: &[Line]) -> Result<String, DrawingAreaErrorKind<std::io::Error>> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (920, 380)).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(72)
            .build_cartesian_2d(range(lines, |p| p.0), range(lines, |p| p.1))?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .label_style(("sans-serif", 14))
            .x_desc(x)
            .y_desc(y)
            .draw()?;
        for (line, colour) in lines.iter().zip(COLOURS.iter().cycle()) {
            let style = colour.stroke_width(2);
            let points = line.points.iter().copied();
            let drawn = if line.dashed {
                chart.draw_series(DashedLineSeries::new(points, 6, 4, style))?
            } else {
                chart.draw_series(LineSeries::new(points, style))?
            };
            drawn
                .label(line.name.clone())
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .label_font(("sans-serif", 14))
            .background_style(WHITE.mix(0.8))
            .draw()?;
        area.present()?;
    }
    Ok(svg)
}

/// What an axis has to span, with a margin.
fn range(lines: &[Line], pick: fn(&(f64, f64)) -> f64) -> std::ops::Range<f64> {
    let values = || lines.iter().flat_map(|line| &line.points).map(pick);
    let low = values().fold(f64::INFINITY, f64::min);
    let high = values().fold(f64::NEG_INFINITY, f64::max);
    let margin = (0.03 * (high - low)).max(1e-6);
    if low <= high {
        low - margin..high + margin
    } else {
        0.0..1.0
    }
}
