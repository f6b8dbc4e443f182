//! The driven wheels: which joints they are, and on which side.

use slipstream_bus::InputError;

use super::candidates::{self, Candidates, Wheel};
use super::frames::Frames;
use super::pairs;
use super::parts::Parts;
use crate::robot_file::described::Described;
use crate::robot_file::drive::Drive;
use crate::robot_file::words::{in_words, list, one_line};
use crate::sides::{Side, side_of};

/// Most wheels of a robot: those of a heavy transporter.
const MAX_WHEELS: usize = 40;
/// How far a wheel may lie from the middle and be on no side (m).
const MIDDLE_M: f64 = 1e-6;

/// The driven wheels of a robot, each side from the front, opposite of each other.
#[derive(Debug, Default)]
pub(super) struct Wheels<'a> {
    pub(super) right: Vec<Wheel<'a>>,
    pub(super) left: Vec<Wheel<'a>>,
    /// Joints of wheels that steer.
    pub(super) steered: Vec<&'a str>,
    /// Joints called wheels whose axes lie askew on the floor.
    pub(super) askew: Vec<&'a str>,
}

impl<'a> Wheels<'a> {
    /// Finds the wheels, and says what was assumed. `drives` may name them.
    ///
    /// # Errors
    /// A number of a shape that is none; or more wheels than a robot has.
    pub(super) fn find(
        parts: &Parts<'a>,
        frames: &Frames,
        drives: &[&Drive],
        described: &mut Described,
    ) -> Result<Result<Self, String>, InputError> {
        let told = told(parts, drives, described);
        let mut found = candidates::find(parts, frames, &told)?;
        note_others(&found, described);
        choose(parts, &told, &mut found.wheels, described);
        if found.wheels.is_empty() && found.steered.is_empty() {
            found.wheels = candidates::find_fixed(parts, frames)?;
            note_fixed(&found.wheels, described);
        }
        if found.wheels.len() > MAX_WHEELS {
            return Ok(Err(format!("has {} joints of wheels", found.wheels.len())));
        }
        let mut sides = [Vec::new(), Vec::new()];
        for wheel in found.wheels {
            let y_m = wheel.middle().y;
            if y_m.abs() <= MIDDLE_M {
                let joint = wheel.joint;
                described.note(format!(
                    "{joint} lies in the middle, so it is no wheel of the model"
                ));
            } else {
                sides[usize::from(y_m > 0.0)].push(wheel);
            }
        }
        let [right, left] = pairs::opposite(sides, described);
        let wheels = Self {
            right,
            left,
            steered: found.steered,
            askew: found.askew,
        };
        wheels.check_sides(drives, described);
        Ok(Ok(wheels))
    }

    /// The rearmost wheels, right and left.
    pub(super) fn rear(&self) -> Option<[&Wheel<'a>; 2]> {
        Some([self.right.last()?, self.left.last()?])
    }

    /// Whether there is one wheel on each side.
    pub(super) fn are_two(&self) -> bool {
        self.right.len() == 1 && self.left.len() == 1
    }

    /// Names of their joints, right and left.
    pub(super) fn names(&self) -> [Vec<String>; 2] {
        let names = |side: &[Wheel<'_>]| side.iter().map(|own| one_line(own.joint)).collect();
        [names(&self.right), names(&self.left)]
    }

    /// All wheels.
    pub(super) fn all(&self) -> impl Iterator<Item = &Wheel<'a>> {
        self.right.iter().chain(&self.left)
    }

    /// Names, and controllers, that say the other side.
    fn check_sides(&self, drives: &[&Drive], described: &mut Described) {
        for (side, wheels) in Side::BOTH.into_iter().zip([&self.right, &self.left]) {
            for wheel in wheels {
                let y = in_words(wheel.middle().y);
                let (joint, word) = (wheel.joint, side.word());
                if side_of(joint).is_some_and(|own| own != side) {
                    described.note(format!(
                        "{joint} lies {word} of the middle (y = {y}), against its name: check which way x of the base points"
                    ));
                }
                for drive in drives {
                    let has =
                        |side: Side| drive.joints[side as usize].iter().any(|own| own == joint);
                    if !has(side) && Side::BOTH.into_iter().any(has) {
                        described.note(format!(
                            "{joint} lies {word} of the middle (y = {y}), against {}: check which way x of the base points",
                            drive.name
                        ));
                    }
                }
            }
        }
    }
}

/// The joints that drives name, of the first drive of which the description has some on both sides.
fn told(parts: &Parts<'_>, drives: &[&Drive], described: &mut Described) -> Vec<String> {
    let is_here = |name: &&String| parts.joints.iter().any(|joint| joint.name == **name);
    for drive in drives {
        let gone = drive.joints.iter().flatten().filter(|name| !is_here(name));
        let gone: Vec<&str> = gone.map(String::as_str).collect();
        if !gone.is_empty() {
            let (name, gone) = (&drive.name, list(gone.iter().copied()));
            described.note(format!(
                "{name} names joints that the URDF does not have: {gone}"
            ));
        }
        if drive
            .joints
            .iter()
            .all(|side| side.iter().any(|name| is_here(&name)))
        {
            return drive
                .joints
                .iter()
                .flatten()
                .filter(is_here)
                .cloned()
                .collect();
        }
    }
    Vec::new()
}

/// Keeps the candidates that are driven: those that a drive names; else those that are called wheels, if any; of these
/// those that have a motor, if some have none.
fn choose(
    parts: &Parts<'_>,
    told: &[String],
    wheels: &mut Vec<Wheel<'_>>,
    described: &mut Described,
) {
    let is_told = |wheel: &Wheel<'_>| told.iter().any(|name| name == wheel.joint);
    if wheels.iter().any(is_told) {
        wheels.retain(is_told);
        return;
    }
    if wheels.iter().any(|wheel| wheel.is_named) {
        wheels.retain(|wheel| wheel.is_named);
    } else if !wheels.is_empty() {
        let names = list(wheels.iter().map(|wheel| wheel.joint));
        described.note(format!(
            "No joint is called a wheel; these turn without end about an axis across the robot: {names}"
        ));
    }
    let driven = |wheel: &Wheel<'_>| parts.driven.contains(wheel.joint);
    let count = wheels.iter().filter(|wheel| driven(wheel)).count();
    if count > 0 && count < wheels.len() {
        let others = list(
            wheels
                .iter()
                .filter(|wheel| !driven(wheel))
                .map(|wheel| wheel.joint),
        );
        described.note(format!(
            "Not driven by a motor of the file, so no wheel of the model: {others}"
        ));
        wheels.retain(driven);
    }
}

/// Wheels that do not turn in the file.
fn note_fixed(wheels: &[Wheel<'_>], described: &mut Described) {
    if !wheels.is_empty() {
        let names = list(wheels.iter().map(|wheel| wheel.joint));
        described.note(format!(
            "No joint turns a wheel; these are fixed in the file, and count as wheels by their names: {names}"
        ));
    }
}

/// What is called a wheel and is none.
fn note_others(found: &Candidates<'_>, described: &mut Described) {
    for joint in &found.askew {
        described.note(format!(
            "{joint} is no wheel: its axis does not lie across the robot"
        ));
    }
    for joint in &found.loose {
        described.note(format!(
            "{joint} is no wheel: nothing connects it with the base"
        ));
    }
}
