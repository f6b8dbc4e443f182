//! Wheels in columns of joints: `field.name0` beside `field.position0`, or `/joint_states/left_wheel/position`.

use super::guessed::{Guessed, entry};
use super::units::words;
use crate::foreign_csv::entry::{Source, TimeEntry};
use crate::foreign_csv::layout::Sample;
use crate::sides::{Side, side_of};
use crate::table::StreamKind;

/// Said of wheels of which only one each side is read.
const ONE_OF_SEVERAL: &str = "of the wheels on each side, this is the first";

/// A column with a quantity of a joint.
struct Joint {
    index: usize,
    /// Name of the joint, or of the column with it.
    name: String,
    is_angle: bool,
}

/// The wheels, if there is one on each side.
pub(super) fn guess(sample: &Sample, time: TimeEntry) -> Option<Guessed> {
    let mut joints = joints(sample);
    let is_wheel = |joint: &Joint| joint.name.to_lowercase().contains("wheel");
    // Of an arm's joints and wheels, the wheels.
    if joints.iter().any(is_wheel) {
        joints.retain(is_wheel);
    }
    let sides = [true, false].map(|is_angle| {
        Side::BOTH.map(|side| {
            let of_side = joints
                .iter()
                .filter(|joint| joint.is_angle == is_angle && side_of(&joint.name) == Some(side));
            of_side.map(|joint| joint.index).collect::<Vec<_>>()
        })
    });
    let columns = [
        ["angle_right_rad", "angle_left_rad"],
        ["speed_right_rad_s", "speed_left_rad_s"],
    ];
    let mut found = sides
        .into_iter()
        .zip(columns)
        .filter_map(|(sides, columns)| {
            let [right, left] = &sides;
            let both = [*right.first()?, *left.first()?];
            let sources = columns.into_iter().zip(both);
            let sources =
                sources.map(|(column, index)| (column, Source::One(entry(sample, index, 1.0))));
            let wheels = Guessed::new(StreamKind::Wheels, time.clone(), sources.collect());
            Some(match right.len() + left.len() {
                2 => wheels,
                _ => wheels.with_note(ONE_OF_SEVERAL),
            })
        });
    found.next()
}

/// The columns of joints, by the names of columns.
fn joints(sample: &Sample) -> Vec<Joint> {
    let names = &sample.layout.names;
    let columns = names.iter().enumerate();
    let joints = columns.filter_map(|(index, column)| {
        let words = words(column);
        let last = words.last()?;
        if last == "position" || last == "velocity" {
            return Some(Joint {
                index,
                name: column.clone(),
                is_angle: last == "position",
            });
        }
        let (list, is_angle) = if column.contains("position") {
            ("position", true)
        } else if column.contains("velocity") {
            ("velocity", false)
        } else {
            return None;
        };
        // `position0` beside `name0`, whose cells have the joint's name.
        let (before, number) = column.rsplit_once(list)?;
        let is_number = number
            .trim_matches(['_', '[', ']', '.'])
            .parse::<u16>()
            .is_ok();
        let names_it = format!("{before}name{number}");
        let name = names
            .iter()
            .position(|name| *name == names_it)
            .filter(|_| is_number)?;
        let name = sample.rows.first()?.get(name)?.clone();
        Some(Joint {
            index,
            name,
            is_angle,
        })
    });
    joints.collect()
}
