//! Charts of each robot: how far its paths are apart, its spacing error in both recordings, and both paths on the floor.

use maud::{Markup, html};
use slipstream_recording::two_runs::RobotPair;

use crate::parts::{
    Frame, Ink, Points, Row, Rows, Scale, Way, columns_of, floor_scales, gap_of, short,
};

/// Height of a chart (pixels).
const HEIGHT_PX: u32 = 96;

/// Axes that all robots share.
struct Axes {
    time: Scale,
    apart: Scale,
    spacing: Scale,
    columns: usize,
}

/// The charts of the robots, those that are furthest apart first, at most so many.
pub(super) fn robots(robots: &[RobotPair], most: usize) -> Markup {
    let mut seen: Vec<&RobotPair> = robots.iter().filter(|own| has_lines(own)).collect();
    let apart_m = |own: &RobotPair| own.path.map_or(0.0, |path| path.largest_m);
    seen.sort_by(|a, b| apart_m(b).total_cmp(&apart_m(a)));
    let left = seen.len().saturating_sub(most);
    seen.truncate(most);
    let axes = axes(&seen);
    html! {
        @if seen.is_empty() {
            p class="sub" { "No robot has poses in both recordings: there is nothing to draw." }
        }
        @for (place, own) in seen.iter().enumerate() {
            section class=(if place == 0 { "first" } else { "" }) {
                @if robots.len() > 1 { h2 { (own.robot) } }
                (robot(own, place, &axes))
            }
        }
        @if left > 0 { p class="sub" { (left) " more robots are in the table." } }
    }
}

fn has_lines(own: &RobotPair) -> bool {
    !own.lines.apart.is_empty() || own.lines.spacing.iter().any(|line| !line.is_empty())
}

fn axes(robots: &[&RobotPair]) -> Axes {
    let lines = |own: &RobotPair| {
        let all = own.lines.spacing.iter().chain([&own.lines.apart]);
        all.cloned().collect::<Vec<Points>>()
    };
    let ends = robots.iter().flat_map(|own| lines(own));
    let ends = ends.filter_map(|line| Some([line.first()?.0, line.last()?.0]));
    let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |all, own| {
        [all[0].min(own[0]), all[1].max(own[1])]
    });
    let apart = robots.iter().flat_map(|own| &own.lines.apart);
    let spacing = robots
        .iter()
        .flat_map(|own| own.lines.spacing.iter().flatten());
    Axes {
        time: Scale::new(low, high, 7),
        apart: Scale::around(apart.map(|own| 100.0 * own.1), true, 3),
        spacing: Scale::around(spacing.map(|own| 100.0 * own.1), true, 3),
        columns: columns_of(4 * robots.len()),
    }
}

fn robot(own: &RobotPair, place: usize, axes: &Axes) -> Markup {
    let mut rows = Rows::new(format!("b{place}"));
    let spacing = own.spacing.as_ref().map(|spacing| &*spacing.ahead);
    let apart = centimetres(&own.lines.apart);
    if !apart.is_empty() {
        let described = format!("Distance between both paths of {} over time, cm", own.robot);
        let mut frame = Frame::new(axes.time, axes.apart, HEIGHT_PX, described)
            .columns(axes.columns)
            .line(Ink::Before, &apart, gap_of(&apart));
        if spacing.is_none() {
            frame = frame.x_axis("s");
        }
        let words = own.path.map_or_else(String::new, |path| {
            format!("rms {} cm", short(100.0 * path.rms_m))
        });
        rows = rows.row(
            Row::new("Paths apart", "cm", frame)
                .reads(Ink::Before, "cm", &apart, 1)
                .legend(Ink::Before, words),
        );
    }
    if let Some(ahead) = spacing {
        rows = rows.row(spacing_row(own, ahead, axes));
    }
    floor(rows, &own.lines.ways).markup()
}

fn spacing_row(own: &RobotPair, ahead: &str, axes: &Axes) -> Row {
    let [real, simulated] = own.lines.spacing.each_ref().map(|line| centimetres(line));
    let described = format!(
        "Spacing error of {} behind {ahead} over time in both recordings, cm",
        own.robot
    );
    let frame = Frame::new(axes.time, axes.spacing, HEIGHT_PX, described)
        .columns(axes.columns)
        .line(Ink::Measured, &real, gap_of(&real))
        .line(Ink::Before, &simulated, gap_of(&simulated))
        .x_axis("s");
    Row::new(format!("Spacing error behind {ahead}"), "cm", frame)
        .reads(Ink::Measured, "real", &real, 1)
        .reads(Ink::Before, "simulated", &simulated, 1)
        .legend(Ink::Measured, "real")
        .legend(Ink::Before, "simulated")
}

/// The rows with both paths on the floor beside them.
fn floor(rows: Rows, ways: &[Way; 2]) -> Rows {
    let [real, simulated] = ways.each_ref().map(|way| {
        let points = way.iter().map(|own| (own.1, own.2));
        points.collect::<Points>()
    });
    if real.is_empty() && simulated.is_empty() {
        return rows;
    }
    let scales = floor_scales(real.iter().chain(&simulated).copied());
    let described = "Path of the real run and of the simulated run on the floor, in metres";
    let frame = Frame::floor(scales[0], scales[1], described)
        .x_axis("m")
        .trail(Ink::Measured, &real)
        .trail(Ink::Before, &simulated);
    let dots = [Ink::Measured, Ink::Before].into_iter().zip(ways.clone());
    rows.floor(frame, scales, dots)
}

fn centimetres(line: &[(f64, f64)]) -> Points {
    line.iter().map(|(t_s, m)| (*t_s, 100.0 * m)).collect()
}
