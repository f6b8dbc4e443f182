//! The joints that may turn driven wheels, by structure: without end, about an axis across the robot, and below no joint
//! that turns about the vertical, as forks of castors and steering do.

use nalgebra::Vector3;
use slipstream_bus::InputError;

use super::frames::Frames;
use super::parts::{Joint, Parts};
use super::round::{self, Round};
use crate::sides::words;

/// Least share of an axis that is lateral (1): axles are at most 25 degrees askew.
const LATERAL: f64 = 0.9;
/// Least share of an axis that is vertical (1).
const VERTICAL: f64 = 0.7;
/// No wheel hangs on more joints.
const DEEPEST: usize = 100;
/// Words in the names of joints and links that turn and are no driven wheels.
const CASTERS: [&str; 3] = ["caster", "castor", "swivel"];
/// Words of names of tracks.
const TRACKS: [&str; 5] = ["track", "tracks", "crawler", "crawlers", "tread"];
/// Words in the names of wheels.
const WHEELS: [&str; 6] = ["wheel", "whl", "tire", "tyre", "drive", "sprocket"];

/// A wheel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wheel<'a> {
    /// The name of its joint.
    pub(super) joint: &'a str,
    /// Its link.
    pub(super) link: usize,
    /// Where its joint is, in the frame of the base (m).
    pub(super) joint_at: Vector3<f64>,
    /// Its axle, of length 1.
    pub(super) axle: Vector3<f64>,
    /// Its shape, if that is round.
    pub(super) round: Option<Round>,
    /// Whether a name says that it is a wheel.
    pub(super) is_named: bool,
}

impl Wheel<'_> {
    /// Its middle in the frame of the base (m): that of its shape, if known, else where its joint is.
    pub(super) fn middle(&self) -> Vector3<f64> {
        self.joint_at + self.axle * self.beside_m()
    }

    /// How far its shape lies beside its joint, along the axle (m).
    pub(super) fn beside_m(&self) -> f64 {
        let round = self.round.as_ref();
        round.map_or(0.0, |own| (own.middle - self.joint_at).dot(&self.axle))
    }

    /// Its radius (m), if its shape tells.
    pub(super) fn radius_m(&self) -> Option<f64> {
        self.round.as_ref().map(|own| own.radius_m)
    }
}

/// The candidates of a robot, and what else turns that a wheel might.
#[derive(Debug, Default)]
pub(super) struct Candidates<'a> {
    pub(super) wheels: Vec<Wheel<'a>>,
    /// Joints of wheels that turn about the vertical, by a motor or between limits.
    pub(super) steered: Vec<&'a str>,
    /// Joints that are called wheels, and turn about an axis along the floor that is not lateral.
    pub(super) askew: Vec<&'a str>,
    /// Joints that are called wheels, and that nothing connects with the base.
    pub(super) loose: Vec<&'a str>,
}

/// Finds them. `named` are joints that a controller calls its wheels: they need not turn without end.
///
/// # Errors
/// A number of a shape that is none.
pub(super) fn find<'a>(
    parts: &Parts<'a>,
    frames: &Frames,
    named: &[String],
) -> Result<Candidates<'a>, InputError> {
    let mut found = Candidates::default();
    for joint in &parts.joints {
        let is_told = named.iter().any(|name| name == joint.name);
        let is_free = joint.is_endless || (joint.turns && is_told);
        if !is_free || (is_called(parts, joint, &CASTERS) && !is_told) {
            continue;
        }
        let is_named = is_told || is_called(parts, joint, &WHEELS);
        let Some(frame) = frames.get(joint.child) else {
            if is_named {
                found.loose.push(joint.name);
            }
            continue;
        };
        let axle = frame.rotation * joint.axis;
        match above(parts, frames, joint) {
            Above::Caster => continue,
            Above::Steering => {
                found.steered.push(joint.name);
                continue;
            }
            Above::Base => {}
        }
        if axle.y.abs() <= LATERAL {
            if is_named && axle.z.abs() < VERTICAL {
                found.askew.push(joint.name);
            }
            continue;
        }
        found.wheels.push(Wheel {
            joint: joint.name,
            link: joint.child,
            joint_at: frame.offset,
            axle,
            round: round::of_link(parts, frames, joint.child, axle)?,
            is_named,
        });
    }
    Ok(found)
}

/// Whether the wheels turn about x of the base, on both sides of its y: then the base looks along y.
pub(super) fn look_along_y(parts: &Parts<'_>, frames: &Frames) -> bool {
    let mut sides = [0.0_f64; 2];
    for joint in parts.joints.iter().filter(|joint| joint.is_endless) {
        let Some(frame) = frames.get(joint.child) else {
            continue;
        };
        let axle = frame.rotation * joint.axis;
        if axle.y.abs() > LATERAL {
            return false;
        }
        if axle.x.abs() > LATERAL && is_called(parts, joint, &WHEELS) {
            let x_m = frame.offset.x;
            sides = [sides[0].min(x_m), sides[1].max(x_m)];
        }
    }
    sides[0] < 0.0 && sides[1] > 0.0
}

/// Wheels and tracks of a file in which nothing turns: links of such names that are fixed on a side of the base.
///
/// # Errors
/// A number of a shape that is none.
pub(super) fn find_fixed<'a>(
    parts: &Parts<'a>,
    frames: &Frames,
) -> Result<Vec<Wheel<'a>>, InputError> {
    let axle = Vector3::y();
    let mut found = Vec::new();
    for joint in parts.joints.iter().filter(|joint| joint.is_fixed) {
        let is_track = is_track(parts.name(joint.child)) || is_track(joint.name);
        let is_wheel = is_track || is_called(parts, joint, &WHEELS);
        let frame = frames
            .get(joint.child)
            .filter(|frame| frame.offset.y != 0.0);
        if let (Some(frame), true, false) = (frame, is_wheel, is_called(parts, joint, &CASTERS)) {
            let round = round::of_link(parts, frames, joint.child, axle)?;
            found.push(Wheel {
                joint: joint.name,
                link: joint.child,
                joint_at: frame.offset,
                axle,
                round: round.filter(|own| own.is_along),
                is_named: true,
            });
        }
    }
    Ok(found)
}

/// Whether a name is that of a track.
pub(super) fn is_track(name: &str) -> bool {
    let name = name.to_lowercase();
    words(&name).any(|word| TRACKS.contains(&word))
}

/// What carries a wheel.
enum Above {
    /// The base, or a suspension.
    Base,
    /// A fork that turns freely about the vertical.
    Caster,
    /// A joint that turns about the vertical by a motor or between limits.
    Steering,
}

fn above(parts: &Parts<'_>, frames: &Frames, wheel: &Joint<'_>) -> Above {
    for joint in parts.above(wheel.parent).take(DEEPEST) {
        if is_called(parts, joint, &CASTERS) {
            return Above::Caster;
        }
        let axis = frames
            .get(joint.child)
            .map(|frame| frame.rotation * joint.axis);
        if joint.turns && axis.is_some_and(|axis| axis.z.abs() > VERTICAL) {
            let is_steering = !joint.is_endless
                || parts.driven.contains(joint.name)
                || is_called(parts, joint, &["steer"]);
            return match is_steering {
                true => Above::Steering,
                false => Above::Caster,
            };
        }
    }
    Above::Base
}

/// Whether the name of a joint or of its child has one of these words.
fn is_called(parts: &Parts<'_>, joint: &Joint<'_>, words: &[&str]) -> bool {
    let names = [joint.name, parts.name(joint.child)].map(str::to_lowercase);
    names
        .iter()
        .any(|name| words.iter().any(|word| name.contains(word)))
}
