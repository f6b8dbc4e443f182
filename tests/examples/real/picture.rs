//! Pictures of the prediction before and after.

use slipstream_diagnose::{Point, Prediction};
use slipstream_report::{Chart, Line, PictureError, Track};

use crate::study::Study;

/// Length of recording that a picture shows, in windows of 5 s.
const WINDOWS: usize = 12;
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
pub(crate) fn pictures(study: &Study<'_>) -> Result<Vec<Picture>, PictureError> {
    let mut pictures = Vec::new();
    for robot in &study.recording.robots {
        if let Some([before, after]) = study.ends(&robot.name) {
            let file = if study.recording.robots.len() > 1 {
                format!("{}-{}.svg", study.recording.name, robot.name)
            } else {
                format!("{}.svg", study.recording.name)
            };
            let svg = if before.seen.is_empty() {
                heading(before, after)?
            } else {
                path(before, after)?
            };
            let robot = robot.name.clone();
            pictures.push(Picture { robot, file, svg });
        }
    }
    Ok(pictures)
}

fn path(before: &Prediction, after: &Prediction) -> Result<String, PictureError> {
    let seen = Line::new("measured", shown(&before.seen)).dots().colour(5);
    let nominal = Line::new("nominal model", shown(&before.predicted)).dashed();
    let found = Line::new("improved model", shown(&after.predicted));
    let track = Track::new().line(seen).line(nominal.colour(1));
    track.line(found.colour(0)).svg()
}

fn heading(before: &Prediction, after: &Prediction) -> Result<String, PictureError> {
    let degrees = |points: &[Point]| {
        let points = shown(points).into_iter();
        points.map(|(t_s, error)| (t_s, error.to_degrees()))
    };
    let nominal = Line::new("nominal model", degrees(&before.heading)).dashed();
    let found = Line::new("improved model", degrees(&after.heading));
    let chart = Chart::new("t (s)", "heading error (degrees)");
    chart.line(nominal.colour(1)).line(found.colour(0)).svg()
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
