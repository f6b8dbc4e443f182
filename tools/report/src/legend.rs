//! The legend: a strip above the plot, as many rows high as the names need.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::error::DrawError;
use crate::line::{Line, LineStyle};
use crate::style::{FONT_PX, WIDTH_PX, text_width_px};

/// Height of a row (pixels).
const ROW_PX: u32 = 22;
/// From an entry's line sample to its name (pixels).
const SAMPLE_PX: u32 = 34;
/// From an entry's name to the next entry (pixels).
const GAP_PX: u32 = 18;
/// Between the legend and the plot (pixels).
const BELOW_PX: u32 = 6;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Left edge (pixels) and row of every entry.
fn layout(lines: &[Line], left_px: u32) -> Vec<(u32, u32)> {
    let (mut x, mut row) = (left_px, 0);
    let entry = |line: &Line| {
        let width = SAMPLE_PX + text_width_px(&line.name) + GAP_PX;
        if x > left_px && x + width > WIDTH_PX {
            (x, row) = (left_px, row + 1);
        }
        let here = (x, row);
        x += width;
        here
    };
    lines.iter().map(entry).collect()
}

/// Draws the entries into the upper part of `area` and returns the part below.
pub(crate) fn legend<'a>(
    area: &Area<'a>,
    lines: &[Line],
    left_px: u32,
) -> Result<Area<'a>, DrawError> {
    let layout = layout(lines, left_px);
    let rows = layout.last().map_or(0, |(_, row)| row + 1);
    let (strip, below) = area.split_vertically(rows * ROW_PX + BELOW_PX);
    let middle = Pos::new(HPos::Left, VPos::Center);
    for (i, (line, (x, row))) in lines.iter().zip(layout).enumerate() {
        let [x, y] = [x, row * ROW_PX + ROW_PX / 2 + BELOW_PX].map(u32::cast_signed);
        let colour = line.rgb(i);
        let style = colour.stroke_width(2);
        let dashes: &[(i32, i32)] = match line.style {
            LineStyle::Solid => &[(0, 26)],
            LineStyle::Dashed => &[(0, 6), (10, 16), (20, 26)],
            LineStyle::Dots => &[],
        };
        for (from, to) in dashes {
            strip.draw(&PathElement::new([(x + from, y), (x + to, y)], style))?;
        }
        if line.style == LineStyle::Dots {
            for dot in [4, 13, 22] {
                strip.draw(&Circle::new((x + dot, y), 2, colour.filled()))?;
            }
        }
        let text = ("sans-serif", FONT_PX)
            .into_font()
            .color(&BLACK)
            .pos(middle);
        strip.draw_text(&line.name, &text, (x + SAMPLE_PX.cast_signed(), y))?;
    }
    Ok(below)
}

/// Height of the legend (pixels).
pub(crate) fn height_px(lines: &[Line], left_px: u32) -> u32 {
    let rows = layout(lines, left_px).last().map_or(0, |(_, row)| row + 1);
    rows * ROW_PX + BELOW_PX
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_do_not_overlap() {
        let names = [
            "short",
            "a rather long name of a line",
            "r1 encoder",
            "r1 true",
        ];
        let lines = names.repeat(3).into_iter().map(|name| Line::new(name, []));
        let lines: Vec<Line> = lines.collect();
        let layout = layout(&lines, 80);
        for ((line, (x, row)), (next_x, next_row)) in
            lines.iter().zip(&layout).zip(layout.iter().skip(1))
        {
            let end = x + SAMPLE_PX + text_width_px(&line.name);
            assert!(end <= WIDTH_PX);
            assert!((next_row == row && *next_x > end) || *next_row == row + 1);
        }
    }
}
