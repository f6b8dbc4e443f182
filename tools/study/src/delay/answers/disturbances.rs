//! What constant delay, jitter and loss each change.

use super::answer::{StudyAnswer, mean, steady};
use crate::delay::grid::GridCell;
use crate::delay::point::Point;

/// The effect of constant delay: least delay against largest, without jitter and loss.
pub(super) fn constant(points: &[Point]) -> Option<StudyAnswer> {
    let steady = steady(points);
    let delays = steady.iter().map(|point| point.cell.delay_s);
    let (least, most) = (delays.clone().reduce(f64::min)?, delays.reduce(f64::max)?);
    let at = |delay: f64, pick: fn(&Point) -> f64| {
        mean(
            steady
                .iter()
                .filter(|point| point.cell.delay_s == delay)
                .map(|point| pick(point)),
        )
    };
    let speed = [least, most].map(|d| at(d, |point| point.max_desired_speed_m_s));
    let error = [least, most].map(|d| at(d, |point| point.max_spacing_error_m));
    let slip = [least, most].map(|d| at(d, |point| point.slip_time_s));
    Some(StudyAnswer::new(
        "What does constant delay do?",
        format!(
            "From {least} s to {most} s of delay on each link, the mean over all other keys: largest \
             desired speed {:.3} to {:.3} m/s, largest spacing error {:.3} to {:.3} m, slip {:.3} to \
             {:.3} s.",
            speed[0], speed[1], error[0], error[1], slip[0], slip[1]
        ),
        &[
            ("spacing_error_least_delay_m", error[0]),
            ("spacing_error_most_delay_m", error[1]),
            ("desired_speed_least_delay_m_s", speed[0]),
            ("desired_speed_most_delay_m_s", speed[1]),
        ],
    ))
}

/// The effect of jitter or loss: each point against the one that differs only in this key.
pub(super) fn random(
    points: &[Point],
    [what, head]: [&str; 2],
    unit: &str,
    pick: fn(&GridCell) -> f64,
) -> Option<StudyAnswer> {
    let mut levels: Vec<f64> = points.iter().map(|point| pick(&point.cell)).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let (&least, others) = levels.split_first()?;
    let mut rows = Vec::new();
    let mut numbers = Vec::new();
    for &level in others {
        let pairs: Vec<(&Point, &Point)> = points
            .iter()
            .filter(|point| pick(&point.cell) == level)
            .filter_map(|point| {
                let reference = points.iter().find(|other| {
                    pick(&other.cell) == least && differ_only_in(&other.cell, &point.cell, what)
                })?;
                Some((reference, point))
            })
            .collect();
        let change = |value: fn(&Point) -> f64| {
            mean(
                pairs
                    .iter()
                    .map(|(reference, point)| value(point) - value(reference)),
            )
        };
        let error = change(|point| point.max_spacing_error_m);
        let speed = change(|point| point.max_desired_speed_m_s);
        let slip = change(|point| point.slip_time_s);
        rows.push([
            format!("{level}"),
            format!("{:+.1}", 1e2 * error),
            format!("{speed:+.3}"),
            format!("{slip:+.3}"),
        ]);
        numbers.push((format!("{what}_{level}_spacing_error_change_m"), error));
    }
    if rows.is_empty() {
        return None;
    }
    let numbers: Vec<(&str, f64)> = numbers.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    Some(StudyAnswer::new(
        &format!("What does {what} do beside constant delay?"),
        format!(
            "Against {least} {unit} at the same delay, gain, limit and protocol: largest values of all runs, on average \
             over the points. The largest of several runs that differ is above that of runs that do not."
        ),
        &numbers,
    )
    .with_table(
        [
            &format!("{head}, {unit}"),
            "Spacing error, cm",
            "Desired speed, m/s",
            "Slip, s",
        ],
        rows,
    ))
}

/// Whether two cells are equal apart from this key, `jitter` or `loss`.
fn differ_only_in(a: &GridCell, b: &GridCell, key: &str) -> bool {
    let mut a = a.clone();
    if key == "jitter" {
        a.jitter_s = b.jitter_s;
    } else {
        a.loss = b.loss;
    }
    a == *b
}
