//! Two lines over one pair of axes, as an SVG file that is readable on light and dark pages.

use std::fmt::Write as _;

use slipstream_report::parts::Scale;

/// Points of a line: horizontal and vertical value.
pub(crate) type Line = Vec<(f64, f64)>;

/// Size (pixels), and margins left, right, top and bottom.
const SIZE: [f64; 2] = [560.0, 240.0];
const MARGINS: [f64; 4] = [58.0, 16.0, 34.0, 38.0];
const STYLE: &str = "text{font:12px system-ui,sans-serif;fill:#4d5761}path,polyline{fill:none;stroke-width:1}\
    .back{fill:#fff}.grid{stroke:#e1e5e8}.plain{stroke:#8b959d;stroke-width:3}.with{stroke:#0a66a6;stroke-width:1.75}\
    @media(prefers-color-scheme:dark){text{fill:#b6bfc7}.back{fill:#1c2024}.grid{stroke:#343a40}.plain{stroke:#7d868e}\
    .with{stroke:#5db4f2}}";

/// The picture of the plain robot and of the robot with an effect. `names` are those of the axes, with units. On a
/// floor, both axes have one scale.
pub(crate) fn svg(
    lines: &[Line; 2],
    names: [&str; 2],
    legend: [&str; 2],
    is_floor: bool,
) -> String {
    let [left, right, top, bottom] = MARGINS;
    let inside = [SIZE[0] - left - right, SIZE[1] - top - bottom];
    let [x, y] = scales(lines, inside, is_floor);
    let across = |value: f64| left + inside[0] * x.place(value);
    let up = |value: f64| top + inside[1] * (1.0 - y.place(value));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\"><style>{STYLE}</style>\
         <rect class=\"back\" width=\"{w}\" height=\"{h}\" rx=\"6\"/>\n",
        w = SIZE[0],
        h = SIZE[1]
    );
    let bottom_px = top + inside[1];
    for (value, text) in x.ticks() {
        let at = number(across(value));
        let _ = writeln!(
            out,
            "<path class=\"grid\" d=\"M{at} {top}V{bottom_px}\"/><text x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{text}</text>",
            bottom_px + 16.0
        );
    }
    for (value, text) in y.ticks() {
        let at = number(up(value));
        let _ = writeln!(
            out,
            "<path class=\"grid\" d=\"M{left} {at}H{}\"/><text x=\"{}\" y=\"{at}\" dy=\"4\" text-anchor=\"end\">{text}</text>",
            left + inside[0],
            left - 8.0
        );
    }
    for (class, line) in ["plain", "with"].iter().zip(lines) {
        let points: Vec<String> = line
            .iter()
            .map(|point| format!("{},{}", number(across(point.0)), number(up(point.1))))
            .collect();
        let _ = writeln!(
            out,
            "<polyline class=\"{class}\" points=\"{}\"/>",
            points.join(" ")
        );
    }
    let middle = left + inside[0] / 2.0;
    let _ = writeln!(
        out,
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{}</text><text x=\"8\" y=\"20\">{}</text>",
        SIZE[1] - 6.0,
        names[0],
        names[1]
    );
    for (place, (class, words)) in ["plain", "with"].iter().zip(legend).enumerate() {
        let at = SIZE[0] - 270.0 + 90.0 * place as f64;
        let _ = writeln!(
            out,
            "<path class=\"{class}\" d=\"M{at} 16h18\"/><text x=\"{}\" y=\"20\">{words}</text>",
            at + 24.0
        );
    }
    out + "</svg>\n"
}

/// The ranges of both axes.
fn scales(lines: &[Line; 2], inside: [f64; 2], is_floor: bool) -> [Scale; 2] {
    let points = || lines.iter().flatten();
    let x = Scale::around(points().map(|point| point.0), false, 8);
    let y = Scale::around(points().map(|point| point.1), false, 4);
    if !is_floor {
        return [x, y];
    }
    let metre_per_px = ((x.high - x.low) / inside[0]).max((y.high - y.low) / inside[1]);
    let around = |scale: Scale, px: f64, count: usize| {
        let (middle, half) = (
            f64::midpoint(scale.low, scale.high),
            0.5 * metre_per_px * px,
        );
        Scale::new(middle - half, middle + half, count)
    };
    [around(x, inside[0], 8), around(y, inside[1], 4)]
}

/// A place, to a tenth of a pixel: finer than what can differ between two machines.
fn number(px: f64) -> String {
    let text = format!("{px:.1}");
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}
