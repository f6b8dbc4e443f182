//! How far predictions miss, in centimetres and degrees.

use slipstream_answer::{Answer, Budget};

use crate::parts::{short, shown_unit, with_unit};

/// Units of budgets: of the position, of the heading.
const UNITS: [&str; 2] = ["m", "rad"];

/// Error of the position or of the heading, before and after, in a shown unit.
pub(super) struct Error {
    pub(super) ends: [f64; 2],
    pub(super) unit: &'static str,
    /// The robot, where there are several.
    robot: Option<String>,
}

impl Error {
    /// " on r2", where there are several robots.
    pub(super) fn whose(&self) -> String {
        let robot = self.robot.as_ref();
        robot.map_or_else(String::new, |robot| format!(" on {robot}"))
    }
}

/// Errors of the robot that is worst off: position, heading.
pub(super) fn errors(answer: &Answer) -> Vec<Error> {
    let mut out = Vec::new();
    for unit in UNITS {
        let (factor, shown) = shown_unit(unit);
        let worst = match worst(answer, unit) {
            Some(own) => Some((&own.robot, [own.before, own.after])),
            None => of_channels(answer, unit),
        };
        if let Some((robot, ends)) = worst {
            out.push(Error {
                ends: ends.map(|end| factor * end),
                unit: shown,
                robot: Some(robot).filter(|_| has_several(answer)).cloned(),
            });
        }
    }
    out
}

fn has_several(answer: &Answer) -> bool {
    let mut robots = answer.held_out.channels.iter().map(|own| &own.robot);
    let first = robots.next();
    robots.any(|own| Some(own) != first)
}

/// The same from the channels, where there is no budget.
fn of_channels<'a>(answer: &'a Answer, unit: &str) -> Option<(&'a String, [f64; 2])> {
    let names: &[&str] = if unit == "m" {
        &["pose_x", "pose_y"]
    } else {
        &["pose_yaw"]
    };
    let robots = answer.held_out.channels.iter().map(|own| &own.robot);
    let worst = robots.filter_map(|robot| {
        let own = answer.held_out.channels.iter();
        let own = own.filter(|own| own.robot == *robot && names.contains(&own.channel.as_str()));
        let squares = own.fold(None, |sum: Option<[f64; 2]>, own| {
            let [a, b] = sum.unwrap_or([0.0; 2]);
            Some([a + own.rms_before.powi(2), b + own.rms_after.powi(2)])
        })?;
        Some((robot, squares.map(f64::sqrt)))
    });
    worst.max_by(|a, b| a.1[0].total_cmp(&b.1[0]))
}

/// What the model reaches, in words: "1.1 cm and 0.3°".
pub(super) fn reached(answer: &Answer) -> Option<String> {
    let words: Vec<String> = errors(answer)
        .iter()
        .map(|own| with_unit(&short(own.ends[1]), own.unit) + &own.whose())
        .collect();
    (!words.is_empty()).then(|| words.join(" and "))
}

/// What is unexplained where that counts, in shown units: that part of the budget.
pub(super) fn unexplained(answer: &Answer) -> Vec<(f64, &'static str)> {
    let part = |own: &Budget| {
        let mut parts = own.parts.iter();
        let share = parts.find(|part| part.name == "unexplained")?.share;
        (share > 0.005 * own.before).then_some(share)
    };
    let known = UNITS.into_iter().filter_map(|unit| {
        let (factor, shown) = shown_unit(unit);
        Some((factor * part(worst(answer, unit)?)?, shown))
    });
    known.collect()
}

/// The budget of the robot that is worst off.
fn worst<'a>(answer: &'a Answer, unit: &str) -> Option<&'a Budget> {
    let own = answer.budget.iter().filter(|own| own.unit == unit);
    own.max_by(|a, b| a.before.total_cmp(&b.before))
}
