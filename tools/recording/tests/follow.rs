//! Bags whose messages arrive one by one give the rows of the whole bag, also where a row needs several messages.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

#[path = "external/python.rs"]
mod python;
#[path = "external/rows.rs"]
mod rows_of;

use std::cell::RefCell;
use std::fs::File;
use std::path::{Path, PathBuf};

use rows_of::{Rows, assert_same, rows};
use slipstream_recording::{Followed, Follower, Map, Recording, TopicMap, read_mapped};

/// The MCAP files below a folder.
fn bags(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(bags(&path));
        } else if path.extension().is_some_and(|own| own == "mcap") {
            all.push(path);
        }
    }
    all.sort();
    all
}

/// The rows of a bag whose messages arrive one by one, and the number of pieces.
fn followed(path: &Path, map: &TopicMap) -> (Rows, usize) {
    let mut pieces: Vec<Recording> = Vec::new();
    let sink = |own| match own {
        Followed::Rows(piece) => pieces.push(*piece),
        Followed::Note(_) => {}
        Followed::Failed(error) => panic!("{}: {error}", path.display()),
    };
    let follower = Follower::new(path, Some(map.clone()), Vec::new(), sink);
    let follower = RefCell::new(follower);
    Follower::read(&follower, File::open(path).unwrap(), path).unwrap();
    follower.borrow_mut().finish();
    drop(follower);
    (rows(&pieces), pieces.len())
}

#[test]
fn messages_one_by_one_give_the_rows_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    for script in ["write_sources", "write_chains", "write_guesses"] {
        let out = folder.path().join(script);
        if python::script(&format!("{script}.py"), &[&out]).is_none() {
            return;
        }
    }
    let (mut compared, mut most_pieces) = (0, 0);
    for path in bags(folder.path()) {
        // Where the marker is on the robot is said at the end: before, nobody can know its pose.
        if path.ends_with("captured.mcap") {
            continue;
        }
        let Ok(guessed) = read_mapped(&path, &Map::None) else {
            continue;
        };
        let Some((_, map)) = guessed.guesses.first().and_then(|own| own.split_once('\n')) else {
            continue;
        };
        let map = TopicMap::parse(map, Path::new("map.toml")).unwrap();
        let Ok(whole) = read_mapped(&path, &Map::Topics(map.clone())) else {
            continue;
        };
        println!("{}", path.display());
        let (own, pieces) = followed(&path, &map);
        assert_same(&own, &rows([&whole.recording]));
        compared += 1;
        most_pieces = most_pieces.max(pieces);
    }
    assert!(compared > 20, "{compared} bags");
    assert!(most_pieces > 10, "{most_pieces} pieces");
}
