//! Reports: one HTML file with text, tables and figures that needs nothing else.
//!
//! A [`Page`] is written from top to bottom. Figures are SVG text: [`Chart`] (lines over axes),
//! [`Track`] (paths on the floor, both axes to one scale), [`Histogram`] and [`Timeline`]. Axes
//! carry what they mean with the unit; the legend stands above the plot, where it covers nothing.
//!
//! ```
//! use slipstream_report::{Chart, Line, Page};
//!
//! let mut page = Page::new("A robot drives", "slipstream run");
//! page.section("Position");
//! let driven = Line::new("camera", [(0.0, 0.0), (1.0, 0.4), (2.0, 0.9)]);
//! let told = Line::new("encoder", [(0.0, 0.0), (1.0, 0.5), (2.0, 1.1)]).dashed();
//! let chart = Chart::new("t (s)", "x (m)").line(driven).line(told);
//! page.figure(&chart.svg()?, "Where it was, and where it thought it was.");
//! let html = page.end();
//! # assert!(html.contains("encoder"));
//! # Ok::<(), slipstream_report::PictureError>(())
//! ```

mod chart;
mod histogram;
mod legend;
mod line;
mod page;
mod range;
mod timeline;
mod track;

pub use chart::Chart;
pub use histogram::Histogram;
pub use line::Line;
pub use page::Page;
pub use timeline::{Row, Timeline};
pub use track::Track;

use plotters::style::RGBColor;

/// A figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("a figure could not be drawn: {0}")]
pub struct PictureError(String);

type DrawError = plotters::drawing::DrawingAreaErrorKind<std::io::Error>;

impl From<DrawError> for PictureError {
    fn from(error: DrawError) -> Self {
        Self(error.to_string())
    }
}

/// Width of every figure (pixels).
const WIDTH: u32 = 920;
/// Right of a plot, so that half of the axis' last number fits (pixels).
const RIGHT_PX: u32 = 32;
/// Size of letters (pixels; the drawing library writes them a fifth smaller).
const FONT_PX: u32 = 16;
/// Width that a letter takes at most on average (pixels).
const LETTER_PX: u32 = 8;
/// Colours that stay apart in print and for the colour-blind (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x33, 0x33, 0x33),
];

/// Pixels that a text takes at most.
fn width_px(text: &str) -> u32 {
    u32::try_from(text.chars().count()).map_or(WIDTH, |letters| letters * LETTER_PX)
}
