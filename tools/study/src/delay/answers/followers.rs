//! What delay does to the followers: slip, string stability, growth with the length of the platoon.

use super::answer::{Answer, steady};
use crate::StudyError;
use crate::delay::grid::{Cell, Grid};
use crate::delay::point::Point;
use crate::delay::run_points::run_points;

/// Numbers of robots that show the growth with the length of the platoon.
const PLATOON_SIZES: [u32; 4] = [2, 3, 5, 8];

/// The smallest delay at which a follower slips, for each gain, limit and protocol.
pub(super) fn slip(points: &[Point]) -> Answer {
    let steady = steady(points);
    let mut groups: Vec<(&Cell, Option<(f64, f64)>)> = Vec::new();
    for point in &steady {
        let cell = &point.cell;
        let same = |other: &&mut (&Cell, Option<(f64, f64)>)| {
            let mut at_this_delay = other.0.clone();
            at_this_delay.delay_s = cell.delay_s;
            at_this_delay == *cell
        };
        let slipping = (point.slip_time_s > 0.0).then_some((cell.delay_s, point.slip_time_s));
        match groups.iter_mut().find(same) {
            None => groups.push((cell, slipping)),
            Some((_, first)) => {
                let earlier = |(delay, _): &(f64, f64)| first.is_none_or(|(d, _)| *delay < d);
                *first = slipping.filter(earlier).or(*first);
            }
        }
    }
    let line = |(cell, first): &(&Cell, Option<(f64, f64)>)| {
        let Cell {
            k_x,
            torque_limit,
            protocol,
            ..
        } = cell;
        let begins = first.map_or("nowhere in the grid".to_owned(), |(delay, slip)| {
            format!("at {delay} s ({slip:.3} s)")
        });
        format!("k_x {k_x}, limit {torque_limit}, {protocol}: {begins}")
    };
    let lines: Vec<String> = groups.iter().map(line).collect();
    Answer::new(
        "At which delay does slip begin?",
        format!(
            "The smallest delay of the grid with any slip of a follower: {}. Where it is the grid's \
             first, the profile's own acceleration makes them slip without delay.",
            lines.join("; ")
        ),
        &[],
    )
}

/// The measured gain of the spacing error from robot to robot, beside that of the linear model.
pub(super) fn gain(points: &[Point]) -> Option<Answer> {
    let steady = steady(points);
    let both: Vec<(f64, f64)> = steady
        .iter()
        .filter_map(|point| Some((point.string_gain?, point.string_gain_frequency?)))
        .collect();
    let [least, most] = [f64::min, f64::max].map(|pick| {
        let gains = both.iter().map(|(measured, _)| *measured);
        gains.reduce(pick)
    });
    let (least, most) = (least?, most?);
    let growing = both.iter().filter(|(measured, _)| *measured > 1.0).count();
    let linear = both.iter().filter(|(_, linear)| *linear > 1.0).count();
    Some(Answer::new(
        "Does the spacing error grow from robot to robot?",
        format!(
            "The measured gain (largest error of a follower over that of the one ahead) lies between \
             {least:.2} and {most:.2}; above 1 at {growing} of {} points. The linear model without \
             slip and limits has a frequency with a gain above 1 at {linear} of them. The two are \
             different things: the model's gain is that of a front robot that swings for ever at the \
             worst frequency, and one profile excites little of that one; slip and limits are in \
             the measured gain alone.",
            both.len()
        ),
        &[("least_gain", least), ("most_gain", most)],
    ))
}

/// How delay adds up along platoons of several lengths: one run each, under both protocols.
pub(super) fn growth(grid: &Grid, threads: usize) -> Result<Option<Answer>, StudyError> {
    let all = grid.cells();
    let middle = all
        .iter()
        .map(|cell| cell.delay_s)
        .find(|&delay| delay >= 0.1);
    let Some(first) = all.first() else {
        return Ok(None);
    };
    let cells: Vec<Cell> = ["ring", "periodic"]
        .iter()
        .flat_map(|protocol| {
            PLATOON_SIZES.map(|robots| Cell {
                robots,
                protocol: (*protocol).to_owned(),
                delay_s: middle.unwrap_or(first.delay_s),
                ..first.clone()
            })
        })
        .collect();
    let points = run_points(&cells, 1, threads)?;
    let line = |point: &Point| {
        format!(
            "{} {}: age {:.3} s, spacing error {:.3} m, desired speed {:.3} m/s",
            point.cell.protocol,
            point.cell.robots,
            point.age_s,
            point.max_spacing_error_m,
            point.max_desired_speed_m_s
        )
    };
    let lines: Vec<String> = points.iter().map(line).collect();
    let names: Vec<String> = points
        .iter()
        .map(|point| format!("{}_{}_age_s", point.cell.protocol, point.cell.robots))
        .collect();
    let numbers: Vec<(&str, f64)> = names
        .iter()
        .zip(&points)
        .map(|(name, point)| (name.as_str(), point.age_s))
        .collect();
    let delay = points.first().map_or(0.0, |point| point.cell.delay_s);
    Ok(Some(Answer::new(
        "How does it grow with the number of robots?",
        format!(
            "Delay {delay} s on each link, one run each: {}. In a ring a position is renewed once a \
             turn, and a turn takes a link and a wait for each robot; sent at every tick its age does \
             not know how long the platoon is.",
            lines.join("; ")
        ),
        &numbers,
    )))
}
