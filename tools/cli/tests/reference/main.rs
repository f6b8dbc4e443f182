//! The reference in `docs/reference` is written from the code. `just docs` writes it anew; without that, this
//! test compares it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod commands;
mod effects;
mod examples;
mod experiment;
mod files;
mod json;
mod markdown;
mod picture;
mod simulate;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use slipstream_sim::effects::CATALOGUE;

/// Text of each file, by its path in `docs/reference`.
type Files = BTreeMap<PathBuf, String>;

/// Set by `just docs`: the files are written instead of compared.
const WRITE: &str = "SLIPSTREAM_WRITE_REFERENCE";
/// Size of all pictures together at most (bytes).
const PICTURES_BYTES: usize = 400_000;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn generated() -> Files {
    let mut files = Files::new();
    files.insert("columns.md".into(), files::columns());
    files.insert("recording-toml.md".into(), files::recording_toml());
    files.insert("robot-toml.md".into(), files::robot_toml());
    files.insert("experiment.md".into(), experiment::page());
    files.insert("commands.md".into(), commands::page());
    files.insert("json.md".into(), json::page());
    files.insert("effects.md".into(), effects::page());
    let pictures = examples::all().map(|example| {
        let name = format!("pictures/{}.svg", example.effect);
        (name.into(), simulate::picture(example))
    });
    files.extend(pictures);
    files
}

#[test]
fn the_reference_is_that_of_the_code() {
    let folder = root().join("docs/reference");
    let files = generated();
    if std::env::var_os(WRITE).is_some() {
        for (path, text) in &files {
            let path = folder.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
    }
    for (path, text) in &files {
        let committed = std::fs::read_to_string(folder.join(path)).unwrap_or_default();
        let path = path.display();
        assert!(
            committed == *text,
            "docs/reference/{path} is not what the code says; run `just docs`"
        );
    }
    for picture in std::fs::read_dir(folder.join("pictures")).unwrap() {
        let name = PathBuf::from("pictures").join(picture.unwrap().file_name());
        let known = files.contains_key(&name);
        assert!(known, "docs/reference/{}: of no effect", name.display());
    }
}

#[test]
fn every_effect_has_a_small_picture_that_shows_a_difference() {
    let mut bytes = 0;
    assert_eq!(examples::all().len(), CATALOGUE.len());
    for info in CATALOGUE {
        let example = examples::of(info.id);
        let [plain, with_effect] = simulate::lines(example);
        assert!(plain != with_effect, "{}: both lines are one", info.id);
        bytes += simulate::picture(example).len();
    }
    assert!(bytes < PICTURES_BYTES, "{bytes} bytes of pictures");
}
