//! Pictures of the prediction before and after.

use slipstream_answer::Point;
use slipstream_diagnose::Prediction;
use slipstream_report::parts::{Frame, Ink, Scale, floor_scales, svg};

use crate::study::Study;

/// Length of recording that a picture shows, in windows of 5 s.
const WINDOWS: usize = 12;
/// Width of a picture (pixels).
const WIDTH_PX: f64 = 640.0;
/// Largest number of points of a line.
const MAX_POINTS: usize = 600;

/// A picture of one robot.
pub(crate) struct Picture {
    pub(crate) robot: String,
    pub(crate) file: String,
    pub(crate) svg: String,
}

/// A picture of every robot: its path against the camera, or where there is none, the error of its
/// heading.
pub(crate) fn pictures(study: &Study<'_>) -> Vec<Picture> {
    let mut pictures = Vec::new();
    for robot in &study.recording.robots {
        if let Some([before, after]) = study.ends(&robot.name) {
            let file = if study.recording.robots.len() > 1 {
                format!("{}-{}.svg", study.recording.name, robot.name)
            } else {
                format!("{}.svg", study.recording.name)
            };
            let svg = if before.seen.is_empty() {
                heading(before, after)
            } else {
                path(before, after)
            };
            let robot = robot.name.clone();
            pictures.push(Picture { robot, file, svg });
        }
    }
    pictures
}

fn path(before: &Prediction, after: &Prediction) -> String {
    let [seen, nominal, found] =
        [&before.seen, &before.predicted, &after.predicted].map(|own| shown(own));
    let [x, y] = floor_scales(seen.iter().chain(&nominal).chain(&found).copied());
    let frame = Frame::floor(x, y, "path")
        .x_axis("m")
        .trail(Ink::Measured, &seen)
        .trail(Ink::Before, &nominal)
        .trail(Ink::After, &found);
    let measured = (Ink::Measured, "measured");
    svg(
        &frame,
        WIDTH_PX,
        &[
            measured,
            (Ink::Before, "nominal model"),
            (Ink::After, "improved model"),
        ],
    )
}

fn heading(before: &Prediction, after: &Prediction) -> String {
    let degrees = |points: &[Point]| -> Vec<Point> {
        let points = shown(points).into_iter();
        points
            .map(|(t_s, error)| (t_s, error.to_degrees()))
            .collect()
    };
    let lines = [&before.heading, &after.heading].map(|own| degrees(own));
    let times = || {
        lines
            .iter()
            .flatten()
            .map(|p| p.0)
            .filter(|t| t.is_finite())
    };
    let ends = [
        times().fold(f64::INFINITY, f64::min),
        times().fold(f64::NEG_INFINITY, f64::max),
    ];
    let y = Scale::around(lines.iter().flatten().map(|p| p.1), true, 4).of_degrees();
    let frame = Frame::new(Scale::new(ends[0], ends[1], 6), y, 260, "heading error")
        .x_axis("s")
        .y_unit("°")
        .line(Ink::Before, &lines[0], f64::INFINITY)
        .line(Ink::After, &lines[1], f64::INFINITY);
    svg(
        &frame,
        WIDTH_PX,
        &[
            (Ink::Before, "heading error, nominal model"),
            (Ink::After, "improved model"),
        ],
    )
}

/// The first pieces, thinned.
fn shown(points: &[Point]) -> Vec<Point> {
    let mut gaps = points.iter().enumerate().filter(|(_, p)| p.0.is_nan());
    let end = gaps.nth(WINDOWS - 1).map_or(points.len(), |(i, _)| i);
    let stride = end.div_ceil(MAX_POINTS).max(1);
    let kept = points[..end].iter().enumerate();
    let kept = kept.filter(|(i, p)| i % stride == 0 || p.0.is_nan());
    kept.map(|(_, point)| *point).collect()
}
