//! Recordings that are played, and files that grow.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;
#[path = "common/runs.rs"]
mod runs;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::time::Duration;

use common::{assert_same, cart, hear_all, hear_until, rows};
use mcap::records::MessageHeader;
use slipstream_bag::{Announced, Listener};
use slipstream_live::source::{Growing, Heard, Replay, Source as _};
use slipstream_recording::run_writer::RunWriter;
use slipstream_recording::{TopicMap, read, read_messages};

/// A run of some seconds, as the bytes of its file.
fn own_file() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut run = RunWriter::to_sink(&mut bytes, Path::new("run.mcap"), &runs::header()).unwrap();
    for second in 0..8 {
        runs::write(&mut run, second * 50..(second + 1) * 50, &mut || ());
        run.flush().unwrap();
    }
    run.finish().unwrap();
    bytes
}

/// The topics and messages of a bag.
#[derive(Default)]
struct Messages {
    topics: Vec<(String, [String; 3], Vec<u8>)>,
    messages: Vec<(String, u64, Vec<u8>)>,
}

impl Listener for Messages {
    fn announced(&mut self, own: &Announced<'_>) {
        let words = [own.schema_name, own.schema_encoding, own.encoding].map(str::to_owned);
        let topic = own.topic.to_owned();
        self.topics.push((topic, words, own.schema.to_vec()));
    }

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        self.messages.push((topic.to_owned(), t_ns, data.to_vec()));
    }
}

/// The bag of the example in small chunks, in `parts` files.
fn foreign_files(parts: usize) -> Vec<Vec<u8>> {
    let mut bag = Messages::default();
    read_messages(&cart(), &mut bag).unwrap();
    let each = bag.messages.len().div_ceil(parts);
    let files = bag.messages.chunks(each).map(|messages| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new().chunk_size(Some(20_000));
        let mut writer = options.create(&mut bytes).unwrap();
        let mut ids = BTreeMap::new();
        for (topic, [name, schema_encoding, encoding], text) in &bag.topics {
            let schema = writer.add_schema(name, schema_encoding, text).unwrap();
            let metadata = BTreeMap::new();
            let id = writer.add_channel(schema, topic, encoding, &metadata);
            ids.insert(topic, id.unwrap());
        }
        for (topic, t_ns, data) in messages {
            let header = MessageHeader {
                channel_id: ids[topic],
                sequence: 0,
                log_time: *t_ns,
                publish_time: *t_ns,
            };
            writer.write_to_known_channel(&header, data).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        bytes.into_inner()
    });
    files.collect()
}

/// Writes a file in pieces of which most end in the middle of a chunk.
fn grow(path: &Path, bytes: &[u8]) {
    let mut file = File::create(path).unwrap();
    for (index, piece) in bytes.chunks(bytes.len() / 23 + 1).enumerate() {
        let (begin, end) = piece.split_at(piece.len() * (index % 3) / 3);
        for part in [begin, end] {
            file.write_all(part).unwrap();
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn the_pieces_of_a_recording_are_the_recording() {
    for bytes in [std::fs::read(cart()).unwrap(), own_file()] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        std::fs::write(&path, bytes).unwrap();
        let whole = read(&path).unwrap().recording;
        let expected = rows([&whole]);
        let mut replay = Replay::new("run", whole, None);
        let (pieces, _) = hear_all(&mut replay);
        assert!(pieces.len() > 10, "{}", pieces.len());
        assert_same(&rows(&pieces), &expected);
    }
}

#[test]
fn a_recording_that_is_played_takes_its_time() {
    let whole = read(&cart()).unwrap().recording;
    let began = std::time::Instant::now();
    let mut replay = Replay::new("cart", whole, Some(20.0));
    let first = replay.hear(Duration::ZERO).unwrap();
    assert!(matches!(first, Heard::Nothing));
    let (pieces, _) = hear_all(&mut replay);
    let most_s = began.elapsed().as_secs_f64() * 20.0;
    let ends = pieces.iter().flat_map(|own| &own.robots[0].pose);
    let last_s = ends
        .filter_map(|own| own.t_s.last())
        .fold(0.0, |a: f64, b| a.max(*b));
    assert!(
        last_s <= most_s + 0.5,
        "{last_s} s of the recording after {most_s} s"
    );
}

#[test]
fn a_file_that_grows_gives_the_rows_of_the_complete_one() {
    for (bytes, is_own) in [(own_file(), true), (foreign_files(1).remove(0), false)] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bag.mcap");
        File::create(&path).unwrap();
        let mut growing = Growing::open(&path, None, Vec::new()).unwrap();
        let (pieces, said) = std::thread::scope(|scope| {
            scope.spawn(|| grow(&path, &bytes));
            hear_all(&mut growing)
        });
        let whole = read(&path).unwrap().recording;
        assert_same(&rows(&pieces), &rows([&whole]));
        let last = pieces.last().unwrap();
        let names = |own: &slipstream_recording::Recording| {
            let robots = own.robots.iter();
            robots.map(|own| own.name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(names(last), names(&whole));
        assert_eq!((&last.name, last.read_from), (&whole.name, whole.read_from));
        let counts = |own: &slipstream_recording::Recording| own.robots[0].encoder_counts_per_rev;
        assert_eq!(counts(last), counts(&whole));
        assert_eq!(
            said.iter().any(|own| own.contains("guessed topics")),
            !is_own,
            "{said:?}"
        );
    }
}

#[test]
fn the_files_of_a_folder_are_read_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let parts = foreign_files(3);
    let path = |index: usize| folder.path().join(format!("rosbag2_{index}.mcap"));
    File::create(path(0)).unwrap();
    let mut growing = Growing::open(folder.path(), None, Vec::new()).unwrap();
    let (pieces, said) = std::thread::scope(|scope| {
        scope.spawn(|| {
            for (index, bytes) in parts.iter().enumerate() {
                // The recorder of the second part is killed before it writes the index.
                let end = if index == 1 {
                    bytes.len() * 2 / 3
                } else {
                    bytes.len()
                };
                grow(&path(index), &bytes[..end]);
            }
            std::fs::write(folder.path().join("metadata.yaml"), "").unwrap();
        });
        hear_all(&mut growing)
    });
    assert_eq!(
        said.iter().filter(|own| own.contains("guessed")).count(),
        1,
        "{said:?}"
    );
    assert_eq!(
        said.iter().filter(|own| own.contains("recovered")).count(),
        1,
        "{said:?}"
    );
    std::fs::remove_file(folder.path().join("metadata.yaml")).unwrap();
    let whole = read(folder.path()).unwrap().recording;
    assert_same(&rows(&pieces), &rows([&whole]));
}

#[test]
fn a_file_without_an_end_is_waited_for_and_may_begin_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let bytes = own_file();
    let half = &bytes[..bytes.len() / 2];
    std::fs::write(&path, half).unwrap();
    let mut growing = Growing::open(&path, None, Vec::new()).unwrap();
    hear_until(&mut growing, |pieces, _| pieces.len() > 4);
    let mut silence = 0;
    while silence < 10 {
        match growing.hear(Duration::from_millis(100)).unwrap() {
            Heard::Nothing => silence += 1,
            Heard::Rows(_) => {}
            other => panic!("{other:?}"),
        }
    }
    std::fs::write(&path, &bytes[..half.len() / 2]).unwrap();
    hear_until(&mut growing, |_, said| {
        said.iter().any(|own| own.contains("begun anew"))
    });
    std::fs::write(&path, &bytes).unwrap();
    let (pieces, _) = hear_all(&mut growing);
    assert!(pieces.len() > 10, "{}", pieces.len());
}

#[test]
fn a_map_is_followed_and_what_it_lacks_is_said() {
    let map = |text: &str| TopicMap::parse(text, Path::new("map.toml")).unwrap();
    let own = map("format = 1\n[robots.c]\npose = \"/mocap/cart/pose\"\nimu = \"/never\"\n");
    let mut growing = Growing::open(&cart(), Some(own), Vec::new()).unwrap();
    let (pieces, said) = hear_all(&mut growing);
    let streams: Vec<String> = rows(&pieces).into_keys().collect();
    assert_eq!(streams, ["c/pose"]);
    assert!(
        said.contains(&"no messages yet of /never".to_owned()),
        "{said:?}"
    );

    let wrong = map("format = 1\n[robots.c]\nimu = \"/mocap/cart/pose\"\n");
    let mut growing = Growing::open(&cart(), Some(wrong), Vec::new()).unwrap();
    let error = loop {
        match growing.hear(Duration::from_secs(1)) {
            Ok(Heard::End) => panic!("no error"),
            Ok(_) => {}
            Err(error) => break error.to_string(),
        }
    };
    assert!(error.contains("cannot provide imu"), "{error}");
}

#[test]
fn what_cannot_grow_into_a_bag_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("a.csv");
    std::fs::write(&text, "t_s,x\n0,1\n").unwrap();
    for path in [folder.path(), &text, &folder.path().join("nothing.mcap")] {
        let error = Growing::open(path, None, Vec::new()).map(drop).unwrap_err();
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }
}
