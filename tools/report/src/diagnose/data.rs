//! The data: readings over time, gaps, outliers.

use maud::{Markup, html};
use slipstream_answer::Figures;
use slipstream_recording::recording::Robot;

use super::diagnosis::Diagnosis;
use crate::parts::{Frame, Ink, Scale, fixed, short};

/// A pause this many median steps long, and at least this long (s), is a gap.
const GAP_STEPS: f64 = 5.0;
const GAP_S: f64 = 0.2;
/// Gaps that are boxed.
const BOXED: usize = 60;
/// Runs whose data is drawn.
const RUNS: usize = 12;

/// One stream.
struct DrawnStream<'a> {
    name: &'static str,
    id: &'static str,
    times_s: &'a [f64],
}

/// The section.
pub(super) fn section(diagnosis: &Diagnosis<'_>, machines: &[&Figures]) -> Markup {
    let drawn = |robot: &&Robot| {
        machines.iter().any(|own| own.robot == robot.name)
            || machines.is_empty()
            || is_run(diagnosis)
    };
    let robots: Vec<(&str, &Robot)> = diagnosis
        .recordings
        .iter()
        .flat_map(|own| {
            own.robots
                .iter()
                .filter(drawn)
                .map(move |robot| (own.name.as_str(), robot))
        })
        .collect();
    let several = robots.len() > 1;
    html! {
        section id="data" aria-labelledby="h-data" {
            h2 id="h-data" { "The data" }
            p class="sub" { "One stroke for each reading. Gaps are shaded; outliers carry a dot. Outliers are weighed down, never dropped." }
            @for (recording, robot) in robots.iter().take(RUNS) {
                @if several { h3 { (recording) ", " (robot.name) } }
                (of_robot(diagnosis, robot))
            }
            @if robots.len() > RUNS { p class="sub" { (robots.len() - RUNS) " more runs are not drawn." } }
        }
    }
}

fn is_run(diagnosis: &Diagnosis<'_>) -> bool {
    diagnosis.recordings.iter().any(|own| own.same_robot)
}

fn of_robot(diagnosis: &Diagnosis<'_>, robot: &Robot) -> Markup {
    let streams = streams(robot);
    let ends = || {
        streams
            .iter()
            .flat_map(|own| own.times_s.first().into_iter().chain(own.times_s.last()))
    };
    let low = ends().copied().fold(f64::INFINITY, f64::min);
    let high = ends().copied().fold(f64::NEG_INFINITY, f64::max);
    let x = Scale::new(low, high, 7);
    let last = streams.len().saturating_sub(1);
    html! {
        @for (place, own) in streams.iter().enumerate() {
            (lane(diagnosis, robot, own, x, place == last))
        }
    }
}

fn lane(
    diagnosis: &Diagnosis<'_>,
    robot: &Robot,
    own: &DrawnStream<'_>,
    x: Scale,
    is_last: bool,
) -> Markup {
    let outliers = diagnosis.answer.outliers.iter();
    let outliers = outliers.filter(|found| found.robot == robot.name && found.stream == own.id);
    let odd: Vec<(f64, f64)> = outliers
        .flat_map(|found| found.times_s.iter().map(|t_s| (*t_s, 0.86)))
        .filter(|(t_s, _)| *t_s >= x.low && *t_s <= x.high)
        .collect();
    let gaps = gaps(own.times_s);
    let longest = gaps
        .iter()
        .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    let count = own.times_s.len();
    let duration_s = own.times_s.last().unwrap_or(&0.0) - own.times_s.first().unwrap_or(&0.0);
    let rate = if duration_s > 0.0 {
        (count as f64 - 1.0) / duration_s
    } else {
        0.0
    };
    let mut words = format!(
        "{} readings, {} per second",
        fixed(count as f64, 0),
        short(rate)
    );
    if let Some(longest) = longest {
        words += &format!(
            "; {} gap{}, the longest {} s at {} s",
            gaps.len(),
            if gaps.len() == 1 { "" } else { "s" },
            short(longest[1] - longest[0]),
            fixed(longest[0], 1)
        );
    }
    let mut frame = Frame::new(
        x,
        Scale::new(0.0, 1.0, 1),
        34,
        format!("{}: {words}", own.name),
    );
    if is_last {
        frame = frame.x_axis("s");
    }
    let mut boxed = gaps.clone();
    boxed.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
    for gap in boxed.into_iter().take(BOXED) {
        frame = frame.span(None, gap);
    }
    frame = frame
        .strokes(Ink::Context, own.times_s, 0.7)
        .dots(Ink::Disturbance, &odd, 5.0);
    html! {
        figure class="lane-f" {
            div class="row-h" {
                b { (own.name) } span class="muted" { (words) }
                @if !odd.is_empty() { span class="cd" { (odd.len()) " outlier" @if odd.len() > 1 { "s" } } }
            }
            (frame.markup_without_y())
        }
    }
}

/// Pauses between readings (s).
fn gaps(times_s: &[f64]) -> Vec<[f64; 2]> {
    let mut steps: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    let least = (GAP_STEPS * median).max(GAP_S);
    let pairs = times_s.windows(2).filter(|pair| pair[1] - pair[0] > least);
    pairs.map(|pair| [pair[0], pair[1]]).collect()
}

fn streams(robot: &Robot) -> Vec<DrawnStream<'_>> {
    let all = [
        ("Poses", "pose", robot.pose.as_ref().map(|own| &own.t_s)),
        (
            "Wheels",
            "wheels",
            robot.wheels.as_ref().map(|own| &own.t_s),
        ),
        ("IMU", "imu", robot.imu.as_ref().map(|own| &own.t_s)),
        (
            "Odometry",
            "odometry",
            robot.odometry.as_ref().map(|own| &own.t_s),
        ),
        (
            "Commands",
            "command",
            robot.command.as_ref().map(|own| &own.t_s),
        ),
    ];
    all.into_iter()
        .filter_map(|(name, id, times)| {
            Some(DrawnStream {
                name,
                id,
                times_s: times.filter(|own| !own.is_empty())?,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_five_median_steps_long() {
        let mut times: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
        times.extend([11.0, 11.1, 11.3]);
        assert_eq!(
            gaps(&times),
            [[9.9, 11.0]].map(|g: [f64; 2]| [0.1 * 99.0, g[1]])
        );
    }
}
