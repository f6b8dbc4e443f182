//! What delay does to the followers: slip, string stability, growth with the length of the platoon.

use super::answer::{StudyAnswer, steady};
use crate::StudyError;
use crate::delay::grid::{Grid, GridCell};
use crate::delay::point::Point;
use crate::delay::run_points::run_points;

/// Numbers of robots that show the growth with the length of the platoon.
const PLATOON_SIZES: [u32; 4] = [2, 3, 5, 8];

/// The smallest delay at which a follower slips, for each gain, limit and protocol.
pub(super) fn slip(points: &[Point]) -> StudyAnswer {
    let steady = steady(points);
    let mut groups: Vec<(&GridCell, Option<(f64, f64)>)> = Vec::new();
    for point in &steady {
        let cell = &point.cell;
        let same = |other: &&mut (&GridCell, Option<(f64, f64)>)| {
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
    let row = |(cell, first): &(&GridCell, Option<(f64, f64)>)| {
        let [delay, slip] = match first {
            Some((delay_s, slip_s)) => [format!("{:.0}", 1e3 * delay_s), format!("{slip_s:.3}")],
            None => ["nowhere in the grid".to_owned(), "0".to_owned()],
        };
        [cell.conditions(), delay, slip]
    };
    let least = points
        .iter()
        .map(|point| point.cell.delay_s)
        .fold(f64::INFINITY, f64::min);
    let at_once = groups
        .iter()
        .filter(|(_, first)| first.is_some_and(|(delay_s, _)| delay_s == least));
    let never = groups.iter().filter(|(_, first)| first.is_none());
    StudyAnswer::new(
        "At which delay does slip begin?",
        format!(
            "At the least delay already in {} of {} cases: there the profile's own acceleration makes followers slip. \
             In {} cases at no delay of the grid.",
            at_once.count(),
            groups.len(),
            never.count()
        ),
        &[],
    )
    .with_table(
        ["Case", "Slip from a delay of, ms", "Slip there, s"],
        groups.iter().map(row).collect(),
    )
}

/// The measured gain of the spacing error from robot to robot, beside that of the linear model.
pub(super) fn gain(points: &[Point]) -> Option<StudyAnswer> {
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
    Some(StudyAnswer::new(
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
pub(super) fn growth(grid: &Grid, threads: usize) -> Result<Option<StudyAnswer>, StudyError> {
    let all = grid.cells();
    let middle = all
        .iter()
        .map(|cell| cell.delay_s)
        .find(|&delay| delay >= 0.1);
    let Some(first) = all.first() else {
        return Ok(None);
    };
    let cells: Vec<GridCell> = ["ring", "periodic"]
        .iter()
        .flat_map(|protocol| {
            PLATOON_SIZES.map(|robots| GridCell {
                robots,
                protocol: (*protocol).to_owned(),
                delay_s: middle.unwrap_or(first.delay_s),
                ..first.clone()
            })
        })
        .collect();
    let points = run_points(&cells, 1, threads)?;
    let row = |point: &Point| {
        [
            point.cell.protocol.clone(),
            point.cell.robots.to_string(),
            format!("{:.0}", 1e3 * point.age_s),
            format!("{:.1}", 1e2 * point.max_spacing_error_m),
            format!("{:.3}", point.max_desired_speed_m_s),
        ]
    };
    let rows = points.iter().map(row).collect();
    let ages = points.chunks(PLATOON_SIZES.len()).filter_map(|own| {
        let (first, last) = (own.first()?, own.last()?);
        let protocol = match first.cell.protocol.as_str() {
            "ring" => "in a ring",
            _ => "sent at every tick",
        };
        let [a, b] = [first, last].map(|point| 1e3 * point.age_s);
        Some(format!("from {a:.0} to {b:.0} ms {protocol}"))
    });
    let ages: Vec<String> = ages.collect();
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
    Ok(Some(StudyAnswer::new(
        "How does it grow with the number of robots?",
        format!(
            "From {} to {} robots the age of the position in use goes {}, with {:.0} ms of delay on each link, one run \
             each. In a ring a position is renewed once a turn, and a turn takes a link and a wait for each robot.",
            PLATOON_SIZES[0],
            PLATOON_SIZES[PLATOON_SIZES.len() - 1],
            ages.join(" and "),
            1e3 * delay
        ),
        &numbers,
    )
    .with_table(
        ["Protocol", "Robots", "Age, ms", "Spacing error, cm", "Desired speed, m/s"],
        rows,
    )))
}
