//! A histogram.

use plotters::prelude::*;

use crate::axis::tick_label;
use crate::error::{DrawError, PictureError};
use crate::style::{COLOURS, FONT_PX, RIGHT_MARGIN_PX, WIDTH_PX};

/// Number of bins.
const BINS: usize = 60;
/// Height of the figure (pixels).
const HEIGHT_PX: u32 = 260;

/// A histogram with 60 bins of equal width over the range of the values.
#[derive(Debug, Clone)]
pub struct Histogram {
    x: String,
    y: String,
    values: Vec<f64>,
}

impl Histogram {
    /// A histogram of `values`; `x` names the quantity, such as `delay (ms)`, and `y` what is counted,
    /// such as `messages`. Values that are not finite are left out.
    pub fn new(
        x: impl Into<String>,
        y: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
    ) -> Self {
        Self {
            x: x.into(),
            y: y.into(),
            values: values.into_iter().filter(|v| v.is_finite()).collect(),
        }
    }

    /// The histogram as SVG text.
    ///
    /// # Errors
    /// When the drawing library fails.
    pub fn svg(&self) -> Result<String, PictureError> {
        Ok(self.draw()?)
    }

    /// Lower edge of the first bin, width of a bin, and the count in each.
    fn bins(&self) -> (f64, f64, Vec<u32>) {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .values
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let mut counts = vec![0_u32; BINS];
        if low > high {
            return (0.0, 1.0 / BINS as f64, counts);
        }
        // Equal values get a narrow range around them and fall into the middle bin.
        let span = if high == 0.0 { 1.0 } else { 1e-3 * high.abs() };
        let (low, width) = if low < high {
            (low, (high - low) / BINS as f64)
        } else {
            (low - span / 2.0, span / BINS as f64)
        };
        for value in &self.values {
            let bin = ((value - low) / width) as usize;
            counts[bin.min(BINS - 1)] += 1;
        }
        (low, width, counts)
    }

    fn draw(&self) -> Result<String, DrawError> {
        let (low, width, counts) = self.bins();
        let x_label = tick_label(&(low..low + width * BINS as f64));
        let highest = counts.iter().copied().max().unwrap_or(0).max(1);
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (WIDTH_PX, HEIGHT_PX)).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .margin(12)
                .margin_right(RIGHT_MARGIN_PX)
                .x_label_area_size(44)
                .y_label_area_size(84)
                .build_cartesian_2d(low..low + width * BINS as f64, 0..highest + 1)?;
            chart
                .configure_mesh()
                .disable_x_mesh()
                .light_line_style(TRANSPARENT)
                .label_style(("sans-serif", FONT_PX))
                .x_labels(8)
                .y_labels(6)
                .x_label_formatter(&x_label)
                .x_desc(self.x.as_str())
                .y_desc(self.y.as_str())
                .draw()?;
            let bars = counts.iter().enumerate().filter(|(_, count)| **count > 0);
            chart.draw_series(bars.map(|(i, &count)| {
                let begin = low + width * i as f64;
                Rectangle::new([(begin, 0), (begin + width, count)], COLOURS[0].filled())
            }))?;
            area.present()?;
        }
        Ok(svg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_falls_into_a_bin() {
        for values in [vec![1.0; 7], vec![0.0; 7], (0..7).map(f64::from).collect()] {
            let histogram = Histogram::new("delay (ms)", "messages", values);
            let (low, width, counts) = histogram.bins();
            assert!(width > 0.0 && low.is_finite());
            assert_eq!(counts.iter().sum::<u32>(), 7);
            assert!(histogram.svg().unwrap().contains("delay (ms)"));
        }
        let none = Histogram::new("delay (ms)", "messages", [f64::NAN]);
        assert!(none.svg().unwrap().contains("messages"));
    }
}
