//! A chart as an SVG file of its own, for documents that are no pages.

use std::fmt::Write as _;

use super::frame::Frame;
use super::ink::Ink;

/// Margins (pixels): left, right, top, bottom.
const MARGINS: [f64; 4] = [52.0, 16.0, 30.0, 26.0];
/// Colours of strokes and words in the light page.
const STYLE: &str = "text{font:12px Inter,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif;fill:#5a656e}\
    path{fill:none;stroke-width:1.5;stroke-linejoin:round;stroke-linecap:round;vector-effect:non-scaling-stroke}\
    .g{stroke:#e1e5e8;stroke-width:1}.z{stroke:#a3adb5;stroke-width:1}.bf{stroke:#b54708}.af{stroke:#0a66a6}.rf{stroke:#14181c}\
    .cx{stroke:#8b959d}.ds{stroke:#62244a}.wt{stroke:#12807a}.da{stroke-dasharray:3 3}\
    text.cb{fill:#b54708}text.ca{fill:#0a66a6}text.cr{fill:#14181c}";

/// The chart as an SVG of this width (pixels), with a legend above it. A chart of the floor gets the height that its
/// axes ask for.
pub fn svg(frame: &Frame, width_px: f64, legend: &[(Ink, &str)]) -> String {
    let [left, right, top, bottom] = MARGINS;
    let inside = [
        width_px - left - right,
        frame.height_for(width_px - left - right),
    ];
    let height_px = inside[1] + top + bottom;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_px:.0}\" height=\"{height_px:.0}\" \
         viewBox=\"0 0 {width_px:.0} {height_px:.0}\"><style>{STYLE}</style>\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\
         <svg x=\"{left}\" y=\"{top}\" width=\"{:.1}\" height=\"{:.1}\" viewBox=\"{}\" preserveAspectRatio=\"none\" \
         overflow=\"visible\">{}</svg>",
        inside[0],
        inside[1],
        Frame::view_box(),
        frame.drawn()
    );
    let mut at = left;
    for (ink, words) in legend {
        let _ = write!(
            out,
            "<path class=\"{}\" d=\"M{at:.0} 14h18\"/><text class=\"{}\" x=\"{:.0}\" y=\"18\">{words}</text>",
            ink.stroke(),
            ink.words(),
            at + 24.0
        );
        at += 24.0 + 7.5 * words.chars().count() as f64 + 16.0;
    }
    for (share, text) in frame.words_up() {
        let y = top + inside[1] * (1.0 - share) + 4.0;
        let _ = write!(
            out,
            "<text text-anchor=\"end\" x=\"{:.0}\" y=\"{y:.1}\">{text}</text>",
            left - 6.0
        );
    }
    for (share, text) in frame.words_across() {
        let x = left + inside[0] * share;
        let _ = write!(
            out,
            "<text text-anchor=\"middle\" x=\"{x:.1}\" y=\"{:.0}\">{text}</text>",
            height_px - 8.0
        );
    }
    out + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::Scale;

    #[test]
    fn a_picture_has_marks_ticks_and_a_legend() {
        let line = [(0.0, 0.0), (10.0, 1.0)];
        let frame = Frame::new(
            Scale::new(0.0, 10.0, 4),
            Scale::new(0.0, 1.0, 2),
            100,
            "a line",
        )
        .x_axis("s")
        .y_unit("m")
        .line(Ink::Before, &line, 100.0);
        let text = svg(&frame, 400.0, &[(Ink::Before, "before")]);
        assert!(
            text.contains("class=\"bf\" d=\"M0 1000l4000-1000\""),
            "{text}"
        );
        assert!(
            text.contains(">1.0 m</text>") && text.contains(">10.0 s</text>"),
            "{text}"
        );
        assert!(text.contains(">before</text>"));
    }
}
