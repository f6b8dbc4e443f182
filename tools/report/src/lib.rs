//! Reports: one self-contained HTML file with text, tables and SVG figures.
//!
//! A [`Page`] is written from top to bottom. Figures are SVG text: [`Chart`] (lines over two axes),
//! [`Track`] (paths on the floor, both axes to the same scale), [`Histogram`] and [`Timeline`]. Axis
//! titles name the quantity and its unit. The legend stands above the plot, where it hides nothing.
//!
//! ```
//! use slipstream_report::{Chart, Line, Page};
//!
//! let mut page = Page::new("A robot drives", "slipstream run");
//! page.section("Position");
//! let measured = Line::new("camera", [(0.0, 0.0), (1.0, 0.4), (2.0, 0.9)]);
//! let estimated = Line::new("encoder", [(0.0, 0.0), (1.0, 0.5), (2.0, 1.1)]).dashed();
//! let chart = Chart::new("t (s)", "x (m)").line(measured).line(estimated);
//! page.figure(&chart.svg()?, "Position by camera and by odometry.");
//! let html = page.end();
//! # assert!(html.contains("encoder"));
//! # Ok::<(), slipstream_report::PictureError>(())
//! ```

mod axis;
mod chart;
mod error;
mod histogram;
mod legend;
mod line;
mod page;
mod plot;
mod style;
mod timeline;
mod track;

pub use chart::Chart;
pub use error::PictureError;
pub use histogram::Histogram;
pub use line::Line;
pub use page::Page;
pub use timeline::{Row, Timeline};
pub use track::Track;
