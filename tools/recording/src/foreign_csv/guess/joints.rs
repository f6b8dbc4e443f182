//! Wheels in columns of joints: `field.name0` beside `field.position0`, or `/joint_states/left_wheel/position`.

use super::columns::Columns;
use super::guessed::{Guessed, ONE_OF_SEVERAL};
use crate::foreign_csv::entry::{Source, TimeEntry};
use crate::sides::{Side, side_of};
use crate::table::StreamKind;

/// A column with a quantity of a joint.
struct JointColumn {
    index: usize,
    /// Name of the joint, or of the column with it.
    name: String,
    is_angle: bool,
}

/// The wheels, if there is one on each side. `time_of` gives the time of a message by the words of a column's name.
pub(super) fn guess(
    columns: &Columns<'_>,
    time_of: impl Fn(&[String]) -> Option<TimeEntry>,
) -> Option<Guessed> {
    let mut joints = joints(columns);
    let is_wheel = |joint: &JointColumn| joint.name.to_lowercase().contains("wheel");
    // Of an arm's joints and wheels, the wheels.
    if joints.iter().any(is_wheel) {
        joints.retain(is_wheel);
    }
    let of_sides = |is_angle: bool| {
        let sides = Side::BOTH.map(|side| {
            let is_it =
                |own: &&JointColumn| own.is_angle == is_angle && side_of(&own.name) == Some(side);
            joints.iter().filter(is_it).map(|own| own.index).collect()
        });
        let has_both = sides.iter().all(|side: &Vec<usize>| !side.is_empty());
        has_both.then_some(sides)
    };
    let moves = |sides: &[Vec<usize>; 2]| {
        sides.iter().flatten().any(|index| {
            let mut cells = columns.cells(*index);
            let first = cells.next();
            cells.any(|cell| Some(cell) != first)
        })
    };
    let names = |is_angle| match is_angle {
        true => ["angle_right_rad", "angle_left_rad"],
        false => ["speed_right_rad_s", "speed_left_rad_s"],
    };
    // Some drivers fill the angles with zeros.
    let (angles, speeds) = (of_sides(true), of_sides(false));
    let angles = angles.filter(|angles| moves(angles) || !speeds.as_ref().is_some_and(moves));
    let is_angle = angles.is_some();
    let [right, left] = angles.or(speeds)?;
    let both = [*right.first()?, *left.first()?];
    let time = time_of(columns.words.get(both[0])?)?;
    let sources = names(is_angle).into_iter().zip(both);
    let sources = sources.map(|(name, index)| (name, Source::One(columns.entry(index, 1.0))));
    let wheels = Guessed::new(StreamKind::Wheels, time, sources.collect());
    Some(match right.len() + left.len() {
        2 => wheels,
        _ => wheels.with_note(ONE_OF_SEVERAL),
    })
}

/// The columns of joints, by the names of columns.
fn joints(columns: &Columns<'_>) -> Vec<JointColumn> {
    let names = columns.words.iter().enumerate();
    let joints = names.filter_map(|(index, words)| {
        let column = columns.name(index);
        let last = words.last()?;
        if last == "position" || last == "velocity" {
            return Some(JointColumn {
                index,
                name: words.join("_"),
                is_angle: last == "position",
            });
        }
        let (list, is_angle) = match words.iter().any(|word| word.starts_with("position")) {
            true => ("position", true),
            false => ("velocity", false),
        };
        // `position0` beside `name0`, whose cells have the joint's name.
        let (before, number) = column.rsplit_once(list)?;
        let is_number = number
            .trim_matches(['_', '[', ']', '.'])
            .parse::<u16>()
            .is_ok();
        let name_of_it = format!("{before}name{number}");
        let has_name = |other: &usize| columns.name(*other) == name_of_it;
        let name = (0..columns.words.len())
            .find(has_name)
            .filter(|_| is_number)?;
        let name = columns.cells(name).next()?.clone();
        Some(JointColumn {
            index,
            name,
            is_angle,
        })
    });
    joints.collect()
}
