//! Descriptions of robots that are no robot.toml.

use std::path::Path;

use slipstream_recording::robot_file::{self, Described};
use slipstream_recording::robot_toml;

use crate::one_line::assert_one_line;
use crate::recordings::SEPARATOR;

/// A URDF.
pub(crate) fn urdf(bytes: &[u8]) {
    read(bytes, Path::new("fuzz.urdf"));
}

/// The parameters of a diff_drive_controller.
pub(crate) fn controller_yaml(bytes: &[u8]) {
    read(bytes, Path::new("fuzz.yaml"));
}

/// Constants in the source of a program.
pub(crate) fn constants(bytes: &[u8]) {
    read(bytes, Path::new("fuzz.h"));
}

/// A URDF and the YAML of its controller: the URDF, [`SEPARATOR`], the YAML.
pub(crate) fn urdf_and_yaml(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let separator = std::str::from_utf8(SEPARATOR).expect("a text");
    let (urdf, yaml) = text.split_once(separator).unwrap_or((text, ""));
    let files = [
        (Path::new("fuzz.urdf"), urdf),
        (Path::new("fuzz.yaml"), yaml),
    ];
    match robot_file::parse_all(&files) {
        Ok(described) => check(&described),
        Err(error) => assert_one_line(&error),
    }
}

fn read(bytes: &[u8], path: &Path) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match robot_file::parse(text, path) {
        Ok(described) => check(&described),
        Err(error) => assert_one_line(&error),
    }
}

/// All texts are single lines, and what is written is the same model; what lacks something is refused.
fn check(described: &Described) {
    let taken = described.taken.iter().chain(&described.left_out);
    for own in taken {
        assert_one_line(&own.key);
        assert_one_line(&own.from);
        assert!(own.value.is_finite(), "{own:?}");
    }
    described.notes.iter().for_each(assert_one_line);
    described
        .wheel_joints
        .iter()
        .flatten()
        .for_each(assert_one_line);
    let written = described.to_robot_toml();
    let again = robot_toml::parse(&written, Path::new("robot.toml"));
    match described.model() {
        Ok(model) => {
            let again = again.expect("what was written can be read");
            assert_eq!(again, model);
            assert_eq!(robot_toml::to_text(&again), robot_toml::to_text(&model));
        }
        Err(error) => {
            assert_one_line(&error);
            assert_one_line(&again.expect_err("what lacks something is no robot.toml"));
        }
    }
}
