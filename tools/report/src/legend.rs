//! The legend: a strip above the plot with as many rows as the names need.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::line::{Line, Mark};
use crate::{DrawError, FONT_PX, WIDTH, width_px};

const ROW_PX: u32 = 22;
/// From an entry's sample of the line to its name, and from its name to the next entry.
const SAMPLE_PX: u32 = 34;
const GAP_PX: u32 = 18;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Left end (pixels) and row of every entry.
fn places(lines: &[Line], left_px: u32) -> Vec<(u32, u32)> {
    let (mut x, mut row) = (left_px, 0);
    let place = |line: &Line| {
        let width = SAMPLE_PX + width_px(&line.name) + GAP_PX;
        if x > left_px && x + width > WIDTH {
            (x, row) = (left_px, row + 1);
        }
        let here = (x, row);
        x += width;
        here
    };
    lines.iter().map(place).collect()
}

/// Draws the entries into the upper part of `area`; gives the part below.
pub(crate) fn legend<'a>(
    area: &Area<'a>,
    lines: &[Line],
    left_px: u32,
) -> Result<Area<'a>, DrawError> {
    let places = places(lines, left_px);
    let rows = places.last().map_or(0, |(_, row)| row + 1);
    let (strip, below) = area.split_vertically(rows * ROW_PX + 6);
    let middle = Pos::new(HPos::Left, VPos::Center);
    for (i, (line, (x, row))) in lines.iter().zip(places).enumerate() {
        let [x, y] = [x, row * ROW_PX + ROW_PX / 2 + 6].map(u32::cast_signed);
        let colour = line.shade(i);
        let style = colour.stroke_width(2);
        let dashes: &[(i32, i32)] = match line.mark {
            Mark::Solid => &[(0, 26)],
            Mark::Dashed => &[(0, 6), (10, 16), (20, 26)],
            Mark::Dots => &[],
        };
        for (from, to) in dashes {
            strip.draw(&PathElement::new([(x + from, y), (x + to, y)], style))?;
        }
        if line.mark == Mark::Dots {
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

/// Height that the legend takes (pixels).
pub(crate) fn height_px(lines: &[Line], left_px: u32) -> u32 {
    let rows = places(lines, left_px).last().map_or(0, |(_, row)| row + 1);
    rows * ROW_PX + 6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_follow_each_other_without_touching() {
        let names = [
            "short",
            "a rather long name of a line",
            "r1 encoder",
            "r1 true",
        ];
        let lines = names.repeat(3).into_iter().map(|name| Line::new(name, []));
        let lines: Vec<Line> = lines.collect();
        let places = places(&lines, 80);
        for ((line, (x, row)), (next_x, next_row)) in
            lines.iter().zip(&places).zip(places.iter().skip(1))
        {
            let end = x + SAMPLE_PX + width_px(&line.name);
            assert!(end <= WIDTH);
            assert!((next_row == row && *next_x > end) || *next_row == row + 1);
        }
    }
}
