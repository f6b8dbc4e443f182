//! URDF: links and joints as XML. Meshes are never opened.

mod candidates;
mod frames;
mod geometry;
mod inertia;
mod masses;
mod pairs;
mod parts;
mod plugins;
mod round;
mod sorts;
mod transform;
mod wheels;

use std::path::Path;

use slipstream_bus::InputError;

use self::frames::Frames;
use self::parts::Parts;
use self::wheels::Wheels;
use super::described::{Described, Kind};
use super::drive::Drive;
use super::lengths;
use super::words::list;
use super::xml::{self, Element};

/// Describes the robot of a URDF. `controllers` are what other files say about its drive.
///
/// # Errors
/// If the text is no XML or no URDF, has macros that are not expanded, or a value that is malformed or physically
/// impossible.
pub(super) fn describe(
    text: &str,
    path: &Path,
    controllers: &[Drive],
) -> Result<Described, InputError> {
    let text = text.trim_start_matches('\u{feff}');
    let document = xml::parse(text, path)?;
    let root = Element::root(&document, path)?;
    if root.name() != "robot" {
        let problem = format!("has <{}> where a URDF has <robot>", root.name());
        return Err(root.error(problem, "give the URDF of a robot"));
    }
    let parts = Parts::read(root)?;
    let mut frames = Frames::of(&parts)
        .ok_or_else(|| root.error("has no <link>", "give the URDF of a robot"))?;
    let mut described = Described::new(Kind::Urdf, path);
    let base = parts.name(frames.base);
    if base != "base_link" {
        described.note(format!(
            "No link is called base_link: x of {base} counts as forward, y as left"
        ));
    }
    if candidates::look_along_y(&parts, &frames) {
        frames = frames.along_y();
        described.note(format!(
            "The wheels turn about x of {base}: its y counts as forward, its x as right. Poses of {base} are those of a frame that \
             is turned by a quarter"
        ));
    }
    let plugins = plugins::drives(root, &parts)?;
    let drives: Vec<&Drive> = controllers.iter().chain(&plugins).collect();
    let wheels = Wheels::find(&parts, &frames, &drives, &mut described)?
        .map_err(|problem| root.error(problem, "give the URDF of one robot"))?;
    let sort = sorts::of(&parts, &wheels, &drives);
    if let Some(warning) = sort.warning() {
        described.note(warning);
    }
    described.wheel_joints = wheels.names();
    let geometry = geometry::of_wheels(&parts, &frames, &wheels, &mut described);
    lengths::take(controllers, &plugins, geometry, &mut described);
    described.take_drives(drives);
    note_lengths(root, &mut described);
    let described = described.checked()?;
    with_masses(&parts, &frames, &wheels, described)
}

/// Larger wheels are none in metres (m).
const LARGEST_RADIUS_M: f64 = 3.0;

/// What to say of lengths that are missing, or too large.
fn note_lengths(root: Element<'_>, described: &mut Described) {
    let files = plugins::parameter_files(root);
    if !described.missing.is_empty() && !files.is_empty() {
        described.note(format!(
            "The parameters of its controllers are in {}: give that file, too",
            list(files.into_iter())
        ));
    }
    let radius = described
        .taken
        .iter()
        .find(|own| own.key == "wheel_radius_m");
    if let Some(radius_m) = radius
        .map(|own| own.value)
        .filter(|own| *own > LARGEST_RADIUS_M)
    {
        described.note(format!(
            "No robot has wheels of {radius_m} m: lengths of a URDF are in metres"
        ));
    }
}

/// Adds masses to a description whose lengths are known and possible.
fn with_masses(
    parts: &Parts<'_>,
    frames: &Frames,
    wheels: &Wheels<'_>,
    mut described: Described,
) -> Result<Described, InputError> {
    if let Ok(model) = described.model() {
        let lengths = [model.robot.wheel_radius_m, model.robot.half_track_m];
        masses::take(parts, frames, wheels, lengths, &mut described)?;
    }
    described.checked()
}
