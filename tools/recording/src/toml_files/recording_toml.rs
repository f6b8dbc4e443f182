//! `recording.toml`: the description of a recording. Unknown keys are kept as notes.

use std::path::Path;

use slipstream_bus::InputError;
use toml::{Table, Value};

use super::document::{Entry, Section, TomlFile, counts_value};
use crate::field::{Field, names};
use crate::recording::{ImuKind, Noise, PosePoint, Recording, Robot, is_robot_name};

/// Keys of the root table.
pub const FILE: [Field; 5] = [
    Field::new("format", "", "Version of the format: 1. Required."),
    Field::new(
        "name",
        "",
        "Name of the recording [default: that of the folder].",
    ),
    Field::new("origin", "", "Who or what made it."),
    Field::new(
        "same_robot",
        "",
        "`true` if the folders are runs of one machine, not several machines [default: `false`].",
    ),
    Field::new(
        "robots",
        "",
        "One table for each folder of a robot, `[robots.NAME]`.",
    ),
];
/// Keys of a robot's table.
pub const ROBOT: [Field; 4] = [
    Field::new(
        "encoder_counts_per_rev",
        "counts",
        "Counts in one revolution of the wheel; gears make it a fraction, where wheels.csv holds ticks. Wins over robot.toml, with a warning.",
    ),
    Field::new(
        "pose_point",
        "",
        "Point that pose.csv tracks: `\"centre_of_mass\"` or `\"axle\"`, the middle of the axle.",
    ),
    Field::new(
        "imu",
        "",
        "What imu.csv holds: `\"specific_force\"`, which contains gravity on a slope, or `\"acceleration\"`.",
    ),
    Field::new(
        "noise",
        "",
        "Standard deviations of the sensors, `[robots.NAME.noise]`. What is not given is estimated.",
    ),
];
/// Keys of a robot's noise table, one standard deviation each, in the order of the fields of [`Noise`].
pub const NOISE: [Field; 7] = [
    Field::new("pose_m", "m", "Position in pose.csv, each axis."),
    Field::new("pose_rad", "rad", "Heading in pose.csv."),
    Field::new("imu_m_s2", "m/s²", "Acceleration in imu.csv, each axis."),
    Field::new("imu_rad_s", "rad/s", "Turn rate in imu.csv."),
    Field::new(
        "wheel_rad",
        "rad",
        "Angle in wheels.csv. Ticks have that of rounding, 1/√12 counts, besides.",
    ),
    Field::new("odometry_m_s", "m/s", "Speed in odometry.csv."),
    Field::new("odometry_rad_s", "rad/s", "Turn rate in odometry.csv."),
];

const TOP_KEYS: [&str; 5] = names(&FILE);
const ROBOT_KEYS: [&str; 4] = names(&ROBOT);
const NOISE_KEYS: [&str; 7] = names(&NOISE);

type ParseResult<T> = Result<T, InputError>;

/// Parses the text of a `recording.toml` into a recording without streams. `path` is used in errors
/// only; `name` is the recording's name if the file gives none.
///
/// # Errors
/// If it is not TOML, or a key of the format has an invalid value.
pub fn parse(text: &str, path: &Path, name: &str) -> ParseResult<Recording> {
    let file = TomlFile { path, text };
    let table = file.parse()?;
    let root = file.root(&table);
    root.require_format_1()?;
    let notes: Table = toml::from_str(text)
        .map_err(|e| root.error(e.message().replace('\n', ", "), "correct the TOML syntax"))?;
    let text_at = |key: &str| {
        root.get(key)
            .map(|e| e.text().map(str::to_owned))
            .transpose()
    };
    let mut recording = Recording {
        name: text_at("name")?.unwrap_or_else(|| name.to_owned()),
        origin: text_at("origin")?.unwrap_or_default(),
        same_robot: match root.get("same_robot") {
            Some(entry) => entry.boolean()?,
            None => false,
        },
        notes: without(&notes, &TOP_KEYS),
        ..Recording::default()
    };
    if let Some(robots) = root.section("robots")? {
        for (name, entry) in robots.entries() {
            let robot_notes = notes.get("robots").and_then(|robots| robots.get(name));
            recording
                .robots
                .push(parse_robot(name, &entry, robot_notes)?);
        }
    }
    Ok(recording)
}

fn parse_robot(name: &str, entry: &Entry<'_>, notes: Option<&Value>) -> ParseResult<Robot> {
    if !is_robot_name(name) {
        return Err(entry.error(
            "is not a valid robot name",
            "use letters, digits, `_`, `-` and `.`",
        ));
    }
    let section = entry.section()?;
    Ok(Robot {
        encoder_counts_per_rev: section
            .get("encoder_counts_per_rev")
            .map(|e| e.counts_per_rev())
            .transpose()?,
        pose_point: one_of(
            &section,
            "pose_point",
            &[
                ("centre_of_mass", PosePoint::CentreOfMass),
                ("axle", PosePoint::Axle),
            ],
        )?,
        imu_kind: one_of(
            &section,
            "imu",
            &[
                ("specific_force", ImuKind::SpecificForce),
                ("acceleration", ImuKind::Acceleration),
            ],
        )?,
        noise: match section.section("noise")? {
            Some(noise) => parse_noise(&noise)?,
            None => Noise::default(),
        },
        notes: notes
            .and_then(Value::as_table)
            .map_or_else(Table::new, |table| without(table, &ROBOT_KEYS)),
        ..Robot::named(name)
    })
}

/// The value of a key that allows only some words, if present.
fn one_of<T: Copy>(
    section: &Section<'_>,
    key: &str,
    words: &[(&str, T)],
) -> ParseResult<Option<T>> {
    let Some(entry) = section.get(key) else {
        return Ok(None);
    };
    let word = entry.text()?;
    match words.iter().find(|(known, _)| *known == word) {
        Some((_, value)) => Ok(Some(*value)),
        None => {
            let known: Vec<&str> = words.iter().map(|(known, _)| *known).collect();
            Err(entry.error(
                format!("is \"{word}\""),
                format!("write one of: {}", known.join(", ")),
            ))
        }
    }
}

fn parse_noise(section: &Section<'_>) -> ParseResult<Noise> {
    section.allow_only(&NOISE_KEYS)?;
    let mut values = [None; 7];
    for (key, value) in NOISE_KEYS.iter().zip(&mut values) {
        if let Some(entry) = section.get(key) {
            let sd = entry.number()?;
            if sd < 0.0 {
                return Err(entry.error(format!("is {sd}"), "give 0 or more"));
            }
            *value = Some(sd);
        }
    }
    let [
        pose_m,
        pose_rad,
        imu_m_s2,
        imu_rad_s,
        wheel_rad,
        odometry_m_s,
        odometry_rad_s,
    ] = values;
    Ok(Noise {
        pose_m,
        pose_rad,
        imu_m_s2,
        imu_rad_s,
        wheel_rad,
        odometry_m_s,
        odometry_rad_s,
    })
}

/// The table without the keys that the format defines.
fn without(table: &Table, known: &[&str]) -> Table {
    table
        .iter()
        .filter(|(key, _)| !known.contains(&key.as_str()))
        .map(|(key, value)| (key.clone(), value.clone()))
        .collect()
}

/// The text of a `recording.toml` for the recording.
pub fn to_text(recording: &Recording) -> String {
    let mut root = Table::new();
    root.insert("format".into(), Value::Integer(1));
    root.insert("name".into(), Value::String(recording.name.clone()));
    root.insert("origin".into(), Value::String(recording.origin.clone()));
    root.insert("same_robot".into(), Value::Boolean(recording.same_robot));
    root.extend(recording.notes.clone());
    let robots: Table = recording
        .robots
        .iter()
        .map(|robot| (robot.name.clone(), Value::Table(robot_table(robot))))
        .collect();
    if !robots.is_empty() {
        root.insert("robots".into(), Value::Table(robots));
    }
    // Serialisation cannot fail: a table of tables, strings and numbers is valid TOML.
    toml::to_string(&root).unwrap_or_default()
}

fn robot_table(robot: &Robot) -> Table {
    let mut table = Table::new();
    if let Some(counts) = robot.encoder_counts_per_rev {
        table.insert("encoder_counts_per_rev".into(), counts_value(counts));
    }
    if let Some(point) = robot.pose_point {
        let word = match point {
            PosePoint::CentreOfMass => "centre_of_mass",
            PosePoint::Axle => "axle",
        };
        table.insert("pose_point".into(), word.into());
    }
    if let Some(kind) = robot.imu_kind {
        let word = match kind {
            ImuKind::SpecificForce => "specific_force",
            ImuKind::Acceleration => "acceleration",
        };
        table.insert("imu".into(), word.into());
    }
    table.extend(robot.notes.clone());
    let noise = robot.noise;
    let values = [
        noise.pose_m,
        noise.pose_rad,
        noise.imu_m_s2,
        noise.imu_rad_s,
        noise.wheel_rad,
        noise.odometry_m_s,
        noise.odometry_rad_s,
    ];
    let noise: Table = NOISE_KEYS
        .iter()
        .zip(values)
        .filter_map(|(key, sd)| Some(((*key).to_owned(), Value::Float(sd?))))
        .collect();
    if !noise.is_empty() {
        table.insert("noise".into(), Value::Table(noise));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "format = 1\nname = \"n\"\norigin = \"o\"\nsame_robot = true\nweather = \"rain\"\n\
        [robots.b]\nencoder_counts_per_rev = 238.76\npose_point = \"axle\"\nimu = \"acceleration\"\n\
        mass_kg = 4.5\n[robots.b.noise]\npose_m = 0.002\n[robots.a]\n[network]\nn = 1\n";

    #[test]
    fn round_trip_keeps_everything() {
        let path = Path::new("recording.toml");
        let once = parse(TEXT, path, "").unwrap();
        let names: Vec<&str> = once.robots.iter().map(|r| r.name.as_str()).collect();
        assert_eq!(names, ["b", "a"]);
        assert_eq!(once.robots[0].noise.pose_m, Some(0.002));
        assert_eq!(once.robots[0].pose_point, Some(PosePoint::Axle));
        let text = to_text(&once);
        for kept in ["weather = \"rain\"", "mass_kg = 4.5", "[network]"] {
            assert!(text.contains(kept), "{text}");
        }
        assert_eq!(to_text(&parse(&text, path, "").unwrap()), text);
    }

    #[test]
    fn errors_name_the_line() {
        let cases = [
            ("[robots.r1]\n", "recording.toml:1: format is missing"),
            (
                "format = 1\n[robots.\"../x\"]\n",
                "recording.toml:2: robots.../x is not a valid robot name",
            ),
            (
                "format = 1\n[robots.r1]\npose_point = \"nose\"\n",
                "recording.toml:3: robots.r1.pose_point is \"nose\"; write one of: centre_of_mass",
            ),
            (
                "format = 1\n[robots.r1.noise]\npose_m = -1\n",
                "recording.toml:3: robots.r1.noise.pose_m is -1",
            ),
        ];
        for (text, message) in cases {
            let error = parse(text, Path::new("recording.toml"), "")
                .unwrap_err()
                .to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }
}
