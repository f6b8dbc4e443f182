//! The driven wheels: which joints they are, on which side, and how far apart.

use nalgebra::Vector3;

use super::frames::Frames;
use super::parts::{Joint, Parts};
use crate::robot_file::described::{Described, Missing, in_words};
use crate::sides::{Side, side_of};

/// Least share of an axis that is lateral (1): axles are at most 25 degrees askew.
const LATERAL: f64 = 0.9;
/// Lengths that differ by less are the same (m).
const SAME_M: f64 = 1e-6;
/// How far the axle may lie from the base before it is said (m).
const AXLE_M: f64 = 1e-3;
/// Most wheels of a robot: those of a heavy transporter.
const MAX_WHEELS: usize = 40;
/// Words in the names of joints and links that turn and are no driven wheels.
const OTHERS: [&str; 4] = ["caster", "castor", "steer", "swivel"];

/// A wheel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wheel<'a> {
    /// The name of its joint.
    pub(super) joint: &'a str,
    /// Its link.
    pub(super) link: usize,
    /// Its middle in the frame of the base (m).
    pub(super) centre: Vector3<f64>,
    /// Its axle, of length 1.
    pub(super) axle: Vector3<f64>,
}

/// The driven wheels of a robot, each side from the front.
#[derive(Debug, Default)]
pub(super) struct Wheels<'a> {
    pub(super) right: Vec<Wheel<'a>>,
    pub(super) left: Vec<Wheel<'a>>,
}

impl<'a> Wheels<'a> {
    /// Finds the wheels, and says what was assumed.
    ///
    /// # Errors
    /// More wheels than a robot has.
    pub(super) fn find(
        parts: &Parts<'a>,
        frames: &Frames,
        described: &mut Described,
    ) -> Result<Self, String> {
        let mut found = named_wheels(parts, frames, described);
        if found.is_empty() {
            found = unnamed_wheels(parts, frames, described);
        }
        if found.len() > MAX_WHEELS {
            return Err(format!("has {} joints of wheels", found.len()));
        }
        let driven = |wheel: &Wheel<'_>| parts.driven.contains(wheel.joint);
        let count = found.iter().filter(|wheel| driven(wheel)).count();
        if count > 0 && count < found.len() {
            let others = found.iter().filter(|wheel| !driven(wheel));
            let others = list(others.map(|wheel| wheel.joint));
            described.note(format!(
                "Not driven by a motor of the file, so no wheel of the model: {others}"
            ));
            found.retain(driven);
        }
        let mut wheels = Self::default();
        for wheel in found {
            let y_m = wheel.centre.y;
            if y_m > SAME_M {
                wheels.left.push(wheel);
            } else if y_m < -SAME_M {
                wheels.right.push(wheel);
            } else {
                described.note(format!(
                    "{} lies in the middle, so it is no wheel of the model",
                    wheel.joint
                ));
            }
        }
        for side in [&mut wheels.right, &mut wheels.left] {
            side.sort_by(|a, b| b.centre.x.total_cmp(&a.centre.x));
        }
        wheels.check_names(described);
        Ok(wheels)
    }

    /// The rearmost wheels, right and left.
    pub(super) fn rear(&self) -> Option<[Wheel<'a>; 2]> {
        Some([*self.right.last()?, *self.left.last()?])
    }

    /// Whether there is one wheel on each side.
    pub(super) fn are_two(&self) -> bool {
        self.right.len() == 1 && self.left.len() == 1
    }

    /// Takes the track.
    pub(super) fn take_track(&self, described: &mut Described) {
        let names = |side: &[Wheel<'_>]| side.iter().map(|own| own.joint.to_owned()).collect();
        described.wheel_joints = [names(&self.right), names(&self.left)];
        let remedy = "measure the distance between the middles of the wheels and write half of it";
        let (right, left) = match (self.rear(), self.right.len() == self.left.len()) {
            (Some([right, left]), true) => (right, left),
            (None, _) if self.right.is_empty() && self.left.is_empty() => {
                let problem = "no joint turns a wheel about an axis across the robot";
                described
                    .missing
                    .push(Missing::new("half_track_m", problem, remedy));
                return;
            }
            _ => {
                let count = [&self.right, &self.left].map(Vec::len);
                let problem = format!("{} wheels lie right and {} left", count[0], count[1]);
                described
                    .missing
                    .push(Missing::new("half_track_m", problem, remedy));
                return;
            }
        };
        let from = format!("y of the origins of {} and {}", right.joint, left.joint);
        described.take_half_track(half_track(&right, &left), from);
        self.note_pairs(described);
        note_offsets([&right, &left], described);
        note_axle(self, described);
    }

    /// Of more wheels than the model has.
    fn note_pairs(&self, described: &mut Described) {
        let count = self.right.len() + self.left.len();
        let pairs = self.right.iter().zip(&self.left);
        let tracks: Vec<f64> = pairs.map(|(right, left)| half_track(right, left)).collect();
        let Some((rear, others)) = tracks.split_last() else {
            return;
        };
        if others.is_empty() {
            return;
        }
        described.note(format!(
            "{count} wheels: the model has one pair. Skid steering turns as if the track were wider, which \
             `slipstream diagnose` finds as track_width"
        ));
        if others.iter().any(|own| (own - rear).abs() > SAME_M) {
            let others = list(others.iter().map(|own| in_words(*own)));
            described.note(format!("The track is that of the rear pair; from the front, half_track_m of the others: {others}"));
        }
    }

    /// Names that say the other side.
    fn check_names(&self, described: &mut Described) {
        for (side, wheels) in Side::BOTH.into_iter().zip([&self.right, &self.left]) {
            let is_wrong = |wheel: &&Wheel<'_>| side_of(wheel.joint).is_some_and(|own| own != side);
            for wheel in wheels.iter().filter(is_wrong) {
                let side = side.word();
                described.note(format!(
                    "{} lies {side} of the middle (y = {}), against its name: check which way x of the base points",
                    wheel.joint,
                    in_words(wheel.centre.y)
                ));
            }
        }
    }
}

/// Half of the distance across the robot (m).
fn half_track(right: &Wheel<'_>, left: &Wheel<'_>) -> f64 {
    // Halves first: the sum of the largest numbers would not be finite.
    left.centre.y / 2.0 - right.centre.y / 2.0
}

/// Wheels that do not lie opposite of each other.
fn note_offsets([right, left]: [&Wheel<'_>; 2], described: &mut Described) {
    let [to_left, to_right] = [left.centre.y, -right.centre.y];
    if (to_left - to_right).abs() > SAME_M {
        described.note(format!(
            "The wheels lie {} to the left and {} to the right of the base's middle: half of their distance is taken",
            in_words(to_left),
            in_words(to_right)
        ));
    }
    if (left.centre.x - right.centre.x).abs() > SAME_M {
        let ahead = in_words(left.centre.x - right.centre.x);
        described.note(format!(
            "{} lies {ahead} ahead of {}, which the model leaves out",
            left.joint, right.joint
        ));
    }
}

/// An axle, or a middle of several, that does not lie at the base.
fn note_axle(wheels: &Wheels<'_>, described: &mut Described) {
    let all = wheels.right.iter().chain(&wheels.left);
    let count = all.clone().count().max(1) as f64;
    let axle_m = all.map(|wheel| wheel.centre.x / count).sum::<f64>();
    if axle_m.abs() > AXLE_M {
        described.note(format!(
            "The axle lies at x = {} of the base: poses of the base are those of another point than the axle's middle",
            in_words(axle_m)
        ));
    }
}

/// Wheels by their names.
fn named_wheels<'a>(
    parts: &Parts<'a>,
    frames: &Frames,
    described: &mut Described,
) -> Vec<Wheel<'a>> {
    let mut found = Vec::new();
    for joint in parts.joints.iter().filter(|joint| joint.turns) {
        if !is_called(parts, joint, &["wheel"]) || is_called(parts, joint, &OTHERS) {
            continue;
        }
        match wheel(frames, joint) {
            Some(wheel) if is_lateral(&wheel) => found.push(wheel),
            Some(_) => described.note(format!(
                "{} is no wheel: its axis does not lie across the robot",
                joint.name
            )),
            None => described.note(format!(
                "{} is no wheel: nothing connects it with the base",
                joint.name
            )),
        }
    }
    found
}

/// Wheels by how they turn, where no name says it.
fn unnamed_wheels<'a>(
    parts: &Parts<'a>,
    frames: &Frames,
    described: &mut Described,
) -> Vec<Wheel<'a>> {
    let joints = parts.joints.iter().filter(|joint| joint.is_continuous);
    let joints = joints.filter(|joint| !is_called(parts, joint, &OTHERS));
    let found: Vec<Wheel<'_>> = joints
        .filter_map(|joint| wheel(frames, joint))
        .filter(is_lateral)
        .collect();
    if !found.is_empty() {
        let names = list(found.iter().map(|wheel| wheel.joint));
        described.note(format!("No joint is called a wheel; these turn without end about an axis across the robot: {names}"));
    }
    found
}

/// Whether the name of a joint or of its child has one of these words.
fn is_called(parts: &Parts<'_>, joint: &Joint<'_>, words: &[&str]) -> bool {
    let names = [joint.name, parts.name(joint.child)].map(str::to_lowercase);
    names
        .iter()
        .any(|name| words.iter().any(|word| name.contains(word)))
}

fn wheel<'a>(frames: &Frames, joint: &Joint<'a>) -> Option<Wheel<'a>> {
    let frame = frames.get(joint.child)?;
    let wheel = Wheel {
        joint: joint.name,
        link: joint.child,
        centre: frame.offset,
        axle: frame.rotation * joint.axis,
    };
    Some(wheel)
}

fn is_lateral(wheel: &Wheel<'_>) -> bool {
    wheel.axle.y.abs() > LATERAL
}

/// Texts with commas; at most six.
fn list(texts: impl Iterator<Item = impl Into<String>>) -> String {
    let mut all: Vec<String> = texts.map(Into::into).collect();
    let more = all.len().saturating_sub(6);
    all.truncate(6);
    let text = all.join(", ");
    if more == 0 {
        text
    } else {
        format!("{text} and {more} more")
    }
}
