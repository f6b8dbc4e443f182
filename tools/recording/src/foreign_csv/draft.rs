//! Draft of a column map from the names of columns, to be completed by a person.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::table::ForeignCsv;
use crate::error::Result;
use crate::table::StreamKind;
use crate::toml_files::quoted;

/// A set of columns, each with the words by which a name may mean it: `right enc` are two words of one name, in any
/// order; ` or ` separates names.
type Guess = (StreamKind, &'static [(&'static str, &'static str)]);

const TIME: &str = "t_s or time or t or timestamp or stamp or sec or secs or seconds or time s";

const GUESSES: [Guess; 9] = [
    (
        StreamKind::Pose,
        &[
            ("x_m", "x or x m or pos x or pose x or position x"),
            ("y_m", "y or y m or pos y or pose y or position y"),
            (
                "yaw_rad",
                "yaw or theta or heading or yaw rad or theta rad or heading rad or pose yaw or pose theta",
            ),
        ],
    ),
    (
        StreamKind::Wheels,
        &[
            (
                "ticks_right",
                "right ticks or right enc or right encoder or r ticks or enc r or encoder r",
            ),
            (
                "ticks_left",
                "left ticks or left enc or left encoder or l ticks or enc l or encoder l",
            ),
        ],
    ),
    (
        StreamKind::Wheels,
        &[
            (
                "angle_right_rad",
                "right angle or right angle rad or wheel right or wheel r or right pos",
            ),
            (
                "angle_left_rad",
                "left angle or left angle rad or wheel left or wheel l or left pos",
            ),
        ],
    ),
    (
        StreamKind::Wheels,
        &[
            (
                "speed_right_rad_s",
                "right speed or speed r or right speed rad s or w r or omega r or right vel",
            ),
            (
                "speed_left_rad_s",
                "left speed or speed l or left speed rad s or w l or omega l or left vel",
            ),
        ],
    ),
    (
        StreamKind::Command,
        &[
            (
                "v_m_s",
                "cmd v or v cmd or command v or v ref or cmd linear or v des",
            ),
            (
                "w_rad_s",
                "cmd w or w cmd or command w or w ref or cmd angular or w des or cmd omega",
            ),
        ],
    ),
    (
        StreamKind::Command,
        &[
            (
                "voltage_right_v",
                "right voltage or voltage r or u r or v right",
            ),
            (
                "voltage_left_v",
                "left voltage or voltage l or u l or v left",
            ),
        ],
    ),
    (
        StreamKind::Command,
        &[
            ("torque_right_nm", "right torque or torque r or tau r"),
            ("torque_left_nm", "left torque or torque l or tau l"),
        ],
    ),
    (
        StreamKind::Odometry,
        &[
            (
                "v_m_s",
                "v or v m s or odom v or speed or linear vel or vel",
            ),
            (
                "w_rad_s",
                "w or omega or w rad s or odom w or yaw rate or angular vel",
            ),
        ],
    ),
    (
        StreamKind::Imu,
        &[(
            "gz_rad_s",
            "gz or gyro z or gz rad s or imu gz or imu yaw rate",
        )],
    ),
];

/// A map of the CSV files in a folder, or of one file, with what the names of the columns suggest.
///
/// # Errors
/// If there is no CSV file, or one cannot be read.
pub(crate) fn draft(path: &Path) -> Result<String> {
    let mut text = String::from(
        "# Which column is what. Complete it, then give it with --columns. A cell becomes cell * factor + offset:\n\
         # write { column = \"heading_deg\", factor = 0.017453292519943295 } for degrees, factor = 0.001 for milliseconds or mm.\n\
         format = 1\n",
    );
    let mut known = Vec::new();
    for file in csv_files(path)? {
        let separator = separator_of(&file)?;
        let csv = ForeignCsv::open(&file, separator, true)?;
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "\n# {name} has the columns: {}",
            csv.header().join(", ")
        );
        for (kind, columns) in &GUESSES {
            if known.contains(kind) {
                continue;
            }
            if let Some(stream) = stream(csv.header(), columns) {
                known.push(*kind);
                let _ = writeln!(
                    text,
                    "[robots.robot.{}]\nfile = {}",
                    kind.name(),
                    quoted(&name)
                );
                if separator != b',' {
                    let _ = writeln!(
                        text,
                        "separator = {}",
                        quoted(&(separator as char).to_string())
                    );
                }
                text.push_str(&stream);
            }
        }
    }
    for kind in StreamKind::ALL
        .into_iter()
        .filter(|kind| !known.contains(kind))
    {
        let sets = kind
            .column_sets()
            .iter()
            .map(|set| set.names().collect::<Vec<_>>().join(", "));
        let sets: Vec<String> = sets.collect();
        let _ = writeln!(
            text,
            "\n# [robots.robot.{}]: t_s and {}",
            kind.name(),
            sets.join("; or ")
        );
    }
    Ok(text)
}

/// The keys of a stream, if the names of a file suggest all that it needs.
fn stream(header: &[String], columns: &[(&str, &str)]) -> Option<String> {
    let find = |names: &str| {
        let mut names = names.split(" or ");
        names.find_map(|wanted| header.iter().find(|column| means(column, wanted)))
    };
    let time = find(TIME).or_else(|| {
        header
            .iter()
            .find(|column| words(column).first().is_some_and(|w| w == "time"))
    })?;
    let mut text = format!("t_s = {}\n", quoted(time));
    for (column, names) in columns {
        let _ = writeln!(text, "{column} = {}", quoted(find(names)?));
    }
    Some(text)
}

/// Whether a column's name has just these words, in any order.
fn means(column: &str, wanted: &str) -> bool {
    let mut own = words(column);
    let mut wanted: Vec<&str> = wanted.split(' ').collect();
    own.sort();
    wanted.sort_unstable();
    own == wanted
}

/// The words of a name, in small letters.
fn words(name: &str) -> Vec<String> {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    words
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect()
}

/// The CSV files of a folder, sorted by name; or the file itself.
pub(crate) fn csv_files(path: &Path) -> Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let unreadable = |e| InputError::unreadable(path, &e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        let file = entry.map_err(unreadable)?.path();
        let endings = ["csv", "txt", "tsv", "dat"];
        if file
            .extension()
            .is_some_and(|own| endings.iter().any(|ending| own == *ending))
        {
            files.push(file);
        }
    }
    if files.is_empty() {
        return Err(
            InputError::file(path, "contains no CSV file", "give a folder with CSV files").into(),
        );
    }
    files.sort();
    Ok(files)
}

/// The separator that the first line has most of.
fn separator_of(file: &Path) -> Result<u8> {
    let csv = ForeignCsv::open(file, b'\n', true)?;
    let line = csv.header().first().cloned().unwrap_or_default();
    let count = |separator: u8| line.bytes().filter(|byte| *byte == separator).count();
    let separators = [b',', b';', b'\t'].into_iter().rev();
    Ok(separators
        .max_by_key(|separator| count(*separator))
        .unwrap_or(b','))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foreign_csv::ColumnMap;

    #[test]
    fn names_of_columns_suggest_a_map() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("log.csv");
        std::fs::write(&file, "time;enc_left;enc_right;x;y;theta\n0;1;2;3;4;5\n").unwrap();
        let text = draft(&file).unwrap();
        for line in [
            "ticks_right = \"enc_right\"",
            "yaw_rad = \"theta\"",
            "separator = \";\"",
        ] {
            assert!(text.contains(line), "{text}");
        }
        assert!(ColumnMap::parse(&text, Path::new("map.toml")).is_ok());
    }
}
