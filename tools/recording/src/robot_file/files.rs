//! Several files about one robot, each filling what the others lack.

use std::path::Path;

use slipstream_bus::InputError;

use super::content;
use super::described::{Described, Kind, Source};
use super::drive::{Drive, Length, first_of};
use super::{constants, controller, lengths, urdf};
use crate::toml_files::robot_toml;

/// A file and its text.
pub(super) type File<'a> = (&'a Path, &'a str);

/// What files say about a robot together.
///
/// # Errors
/// If one is malformed; or if two are of a kind of which a robot has one.
pub(super) fn describe(files: &[File<'_>]) -> Result<Described, InputError> {
    let of_kind = |wanted: Kind| {
        let own = files.iter().copied();
        own.filter(move |(path, text)| content::kind(text, path) == wanted)
    };
    let toml = only(of_kind(Kind::RobotToml).collect())?;
    let urdf = only(of_kind(Kind::Urdf).collect())?;
    let mut sources = Vec::new();
    let mut drives = Vec::new();
    for (path, text) in of_kind(Kind::ControllerYaml) {
        let drive = controller::drive(text, path)?;
        sources.push(source(path, Kind::ControllerYaml, title(&drive)));
        drives.push(drive);
    }
    for (path, text) in of_kind(Kind::Constants) {
        drives.push(constants::drive(text, path)?);
        sources.push(source(
            path,
            Kind::Constants,
            Kind::Constants.name().to_owned(),
        ));
    }
    let mut described = match (urdf, sources.first()) {
        (Some((path, text)), _) => {
            let described = urdf::describe(text, path, &drives)?;
            sources.splice(0..0, described.sources.clone());
            described
        }
        (None, Some(first)) => of_drives(first, &drives)?,
        (None, None) => return alone(toml),
    };
    described.kind = sources.first().map_or(described.kind, |own| own.kind);
    described.sources = sources;
    match toml {
        Some((path, text)) => filled(robot_toml::parse(text, path)?, path, described),
        None => Ok(described),
    }
}

fn source(path: &Path, kind: Kind, title: String) -> Source {
    Source {
        file: path.to_owned(),
        kind,
        title,
    }
}

/// The only file of a kind.
fn only(files: Vec<File<'_>>) -> Result<Option<File<'_>>, InputError> {
    if let [(first, text), (second, _), ..] = files.as_slice() {
        let kind = content::kind(text, first).name();
        let problem = format!("is a second {kind}, beside {}", first.display());
        return Err(InputError::file(
            second,
            problem,
            format!("give one {kind} for a robot"),
        ));
    }
    Ok(files.first().copied())
}

/// A robot.toml and nothing else.
fn alone(toml: Option<File<'_>>) -> Result<Described, InputError> {
    match toml {
        Some((path, text)) => Ok(Described::of_model(robot_toml::parse(text, path)?, path)),
        None => Err(InputError::new(
            "--robot",
            "names no file",
            "give a robot.toml or a URDF",
        )),
    }
}

/// What controllers say without a description of the robot.
fn of_drives(first: &Source, drives: &[Drive]) -> Result<Described, InputError> {
    let mut described = Described::new(first.kind, &first.file);
    for drive in drives {
        if let Some(warning) = drive.sort.warning() {
            let own = drive.type_name.as_deref().unwrap_or_default();
            described.note(format!("{} is of type {own}. {warning}", drive.name));
        }
        if let (Some(by), false) = (drive.multipliers.in_words(), drive.has_lengths()) {
            described.note(format!("{} multiplies {by}", drive.name));
        }
    }
    if drives.iter().any(|drive| drive.has_several) {
        described.note(format!(
            "Several wheels on each side: {}",
            lengths::ONE_PAIR
        ));
    }
    lengths::take(drives, &[], lengths::Geometry::default(), &mut described);
    described.take_drives(drives);
    let named = drives
        .iter()
        .find(|own| own.joints.iter().any(|side| !side.is_empty()));
    described.wheel_joints = named.map(|own| own.joints.clone()).unwrap_or_default();
    described.checked()
}

/// What a controller is: its type, if it names one; a diff_drive_controller, if it is called so or names wheels.
fn title(drive: &Drive) -> String {
    const USUAL: &str = "diff_drive_controller";
    let has_wheels = drive.joints.iter().all(|side| !side.is_empty());
    match drive.type_name.as_deref() {
        Some(own) if !own.contains(USUAL) => format!("{own} YAML"),
        None if !has_wheels && !drive.name.contains(USUAL) => {
            Kind::ControllerYaml.name().to_owned()
        }
        _ => format!("{USUAL} YAML"),
    }
}

/// A robot.toml with what others say beside it. Its own values count.
fn filled(
    model: slipstream_bus::RobotModel,
    path: &Path,
    other: Described,
) -> Result<Described, InputError> {
    let mut described = Described::of_model(model, path);
    for key in ["wheel_radius_m", "half_track_m"] {
        let of = |own: &Described| {
            let taken = own.taken.iter().find(|taken| taken.key == key);
            taken.map(|taken| Length::new(taken.value, taken.from.clone()))
        };
        let (_, contradictions) = first_of(key, [of(&described), of(&other)]);
        contradictions.iter().for_each(|note| described.note(note));
    }
    described.fill_from(&other)?;
    described.sources.extend(other.sources);
    Ok(described)
}
