//! How often values fall where.

use plotters::prelude::*;

use crate::range::label;
use crate::{COLOURS, DrawError, FONT_PX, PictureError, RIGHT_PX, WIDTH};

const BARS: usize = 60;
const HEIGHT_PX: u32 = 260;

/// How often values fall where, in sixty bars.
#[derive(Debug, Clone)]
pub struct Histogram {
    x: String,
    y: String,
    values: Vec<f64>,
}

impl Histogram {
    /// What the values mean, such as `delay (ms)`, what is counted, such as `messages`, and the
    /// values; what is not finite is left out.
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
    /// What the drawing library refuses.
    pub fn svg(&self) -> Result<String, PictureError> {
        Ok(self.draw()?)
    }

    /// Where the bars begin, how wide they are, and how many values fall into each.
    fn bars(&self) -> (f64, f64, Vec<u32>) {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .values
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let mut counts = vec![0_u32; BARS];
        if low > high {
            return (0.0, 1.0 / BARS as f64, counts);
        }
        // Values that are all alike stand in the middle.
        let alike = if high == 0.0 { 1.0 } else { 1e-3 * high.abs() };
        let (low, width) = if low < high {
            (low, (high - low) / BARS as f64)
        } else {
            (low - alike / 2.0, alike / BARS as f64)
        };
        for value in &self.values {
            let bar = ((value - low) / width) as usize;
            counts[bar.min(BARS - 1)] += 1;
        }
        (low, width, counts)
    }

    fn draw(&self) -> Result<String, DrawError> {
        let (low, width, counts) = self.bars();
        let x_label = label(&(low..low + width * BARS as f64));
        let most = counts.iter().copied().max().unwrap_or(0).max(1);
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (WIDTH, HEIGHT_PX)).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .margin(12)
                .margin_right(RIGHT_PX)
                .x_label_area_size(44)
                .y_label_area_size(84)
                .build_cartesian_2d(low..low + width * BARS as f64, 0..most + 1)?;
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
    fn every_value_is_in_a_bar() {
        for values in [vec![1.0; 7], vec![0.0; 7], (0..7).map(f64::from).collect()] {
            let histogram = Histogram::new("delay (ms)", "messages", values);
            let (low, width, counts) = histogram.bars();
            assert!(width > 0.0 && low.is_finite());
            assert_eq!(counts.iter().sum::<u32>(), 7);
            assert!(histogram.svg().unwrap().contains("delay (ms)"));
        }
        let none = Histogram::new("delay (ms)", "messages", [f64::NAN]);
        assert!(none.svg().unwrap().contains("messages"));
    }
}
