//! Bags whose messages arrive one by one give the rows of the whole bag, also where a row needs several messages.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

#[path = "external/python.rs"]
mod python;
#[path = "external/rows.rs"]
mod rows_of;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use rows_of::{Rows, assert_same, rows};
use slipstream_bag::{Announced, Listener};
use slipstream_recording::{
    Followed, Follower, Map, Recording, TopicMap, read_mapped, read_messages,
};

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

/// A topic and a message of it, with its time of reception (ns).
type Sent = (usize, u64, Vec<u8>);

/// The topics and messages of the bag of the example.
#[derive(Default)]
struct Bag {
    topics: Vec<(String, [String; 3], Vec<u8>)>,
    messages: Vec<Sent>,
}

impl Listener for Bag {
    fn announced(&mut self, own: &Announced<'_>) {
        let words = [own.encoding, own.schema_name, own.schema_encoding];
        let topic = own.topic.to_owned();
        self.topics
            .push((topic, words.map(str::to_owned), own.schema.to_vec()));
    }

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        let place = self.topics.iter().position(|own| own.0 == topic).unwrap();
        self.messages.push((place, t_ns, data.to_vec()));
    }
}

impl Bag {
    fn of_example() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/cart/bag/bag.mcap");
        let mut bag = Self::default();
        read_messages(&path, &mut bag).unwrap();
        bag
    }

    fn place(&self, topic: &str) -> usize {
        self.topics.iter().position(|own| own.0 == topic).unwrap()
    }

    /// What comes of messages: the pieces and the notes.
    fn follow(&self, messages: &[Sent]) -> (Vec<Recording>, Vec<String>) {
        let (mut pieces, mut notes) = (Vec::new(), Vec::new());
        let sink = |own| match own {
            Followed::Rows(piece) => pieces.push(*piece),
            Followed::Note(note) => notes.push(note),
            Followed::Failed(error) => notes.push(error.to_string()),
        };
        let mut follower = Follower::new(Path::new("ws://robot"), None, Vec::new(), sink);
        let numbers = self.topics.iter().map(|(topic, words, schema)| {
            let [encoding, schema_name, schema_encoding] = words.each_ref().map(String::as_str);
            follower.announced(&Announced {
                topic,
                encoding,
                schema_name,
                schema_encoding,
                schema,
                metadata: &BTreeMap::new(),
            })
        });
        let numbers: Vec<Option<u32>> = numbers.collect();
        for (place, t_ns, data) in messages {
            follower.message(numbers[*place].unwrap(), *t_ns, data);
        }
        follower.finish();
        drop(follower);
        (pieces, notes)
    }
}

#[test]
fn a_topic_that_begins_later_is_a_stream_from_then_on() {
    let bag = Bag::of_example();
    let first_ns = bag.messages[0].1;
    let late = bag.place("/cmd_vel");
    let is_sent = |own: &Sent| own.0 != late || own.1 > first_ns + 7_000_000_000;
    let sent: Vec<Sent> = bag
        .messages
        .iter()
        .filter(|own| is_sent(own))
        .cloned()
        .collect();
    let (pieces, notes) = bag.follow(&sent);
    let (whole, _) = bag.follow(&bag.messages);
    let (own, whole) = (rows(&pieces), rows(&whole));
    for stream in ["robot/angle", "robot/pose"] {
        assert_eq!(own[stream].len(), whole[stream].len(), "{stream}");
    }
    let expected = sent.iter().filter(|own| own.0 == late).count();
    assert!(expected > 50, "{expected}");
    assert_eq!(own["robot/twist"].len(), expected);
    // The same times as if it had been there from the beginning.
    let skipped = whole["robot/twist"].len() - expected;
    assert_eq!(own["robot/twist"], whole["robot/twist"][skipped..]);
    let guesses = notes.iter().filter(|own| own.contains("guessed topics"));
    assert_eq!(guesses.count(), 2, "{notes:?}");
}

#[test]
fn a_clock_that_goes_back_is_passed_on_as_it_is() {
    let bag = Bag::of_example();
    let twice = [&bag.messages[..], &bag.messages[..]].concat();
    let (pieces, _) = bag.follow(&twice);
    let (once, _) = bag.follow(&bag.messages);
    for (stream, once) in rows(&once) {
        let twice = &rows(&pieces)[&stream];
        assert!(*twice == [&once[..], &once[..]].concat(), "{stream}");
    }
}

#[test]
fn messages_that_are_damaged_or_of_no_use_are_said_once() {
    let mut bag = Bag::of_example();
    let pose = bag.place("/mocap/cart/pose");
    for (_, _, data) in bag.messages.iter_mut().filter(|own| own.0 == pose) {
        data.truncate(20);
    }
    let (pieces, notes) = bag.follow(&bag.messages);
    let rows = rows(&pieces);
    assert!(rows.contains_key("robot/angle") && !rows.contains_key("robot/pose"));
    let said = notes
        .iter()
        .filter(|own| own.contains("/mocap/cart/pose: a message is no"));
    assert_eq!(said.count(), 1, "{notes:?}");

    let (pieces, notes) = bag.follow(&[]);
    assert!(pieces.is_empty());
    assert!(notes[0].contains("has no messages"), "{notes:?}");
}
