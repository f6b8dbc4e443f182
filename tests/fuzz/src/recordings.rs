//! Recordings: MCAP files, bags of other robots, folders of CSV files.

use std::cell::RefCell;
use std::path::Path;

use slipstream_recording::{
    ColumnMap, Followed, Follower, Map, TopicMap, check, draft_map, mcap_bytes, read_folder,
    read_mapped, read_mapped_from, read_mcap_from, write_folder,
};

use crate::one_line::assert_one_line;
use crate::scratch;

/// An MCAP file of slipstream.
pub(crate) fn mcap(bytes: &[u8]) {
    let path = Path::new("fuzz.mcap");
    follow(bytes, path, None);
    let import = match read_mcap_from(bytes, bytes.len() as u64, path) {
        Ok(import) => import,
        Err(error) => return assert_one_line(&error),
    };
    let written = mcap_bytes(&import.recording, path).expect("it can be written");
    let again = read_mcap_from(&written[..], written.len() as u64, path).expect("and read");
    assert_eq!(again.warnings, Vec::<String>::new());
    let twice = mcap_bytes(&again.recording, path).expect("and written again");
    assert!(written == twice, "to the bit");
    check(&import.recording, None);
}

/// The topic map of the target `bag`.
pub const MAP: &str = "format = 1\n[robots.a]\ncommand = \"/cmd_vel\"\nodometry = \"/odom\"\n\
    wheels = { topic = \"/joint_states\", right = \"right_wheel_joint\", left = \"left_wheel_joint\" }\n\
    pose = \"/vicon/robot/pose\"\n";

/// The other topic map of the target `bag`: wheels with a topic each, as fields, and as frames that turn.
pub const SOURCES: &str = "format = 1\n[robots.a]\n\
    wheels = { right = { topic = \"/right_ticks\", field = \"data\" }, left = { topic = \"/left_ticks\", field = \"data\" }, \
    quantity = \"ticks\" }\n[robots.b]\n\
    wheels = { topic = \"/tf\", right = \"right_wheel_link\", left = \"left_wheel_link\", quantity = \"angle\" }\n[robots.c]\n\
    wheels = { topic = \"/sensor_state\", right = \"right_encoder\", left = \"left_encoder\", quantity = \"ticks\" }\n";

/// A bag of another robot, with a guessed map and with maps.
pub(crate) fn bag(bytes: &[u8]) {
    let path = Path::new("fuzz.mcap");
    let maps = [MAP, SOURCES].map(|text| TopicMap::parse(text, Path::new("map.toml")));
    let [one, two] = maps.map(|map| map.expect("a map"));
    for map in [None, Some(&one), Some(&two)] {
        match read_mapped_from(bytes, path, map) {
            Ok(import) => {
                mcap_bytes(&import.recording, path).expect("it can be written");
            }
            Err(error) => assert_one_line(&error),
        }
        follow(bytes, path, map);
    }
}

/// An MCAP file as if it were still being recorded.
fn follow(bytes: &[u8], path: &Path, map: Option<&TopicMap>) {
    let sink = |followed| match followed {
        Followed::Rows(piece) => drop(mcap_bytes(&piece, path).expect("it can be written")),
        Followed::Note(_) => {}
        Followed::Failed(error) => assert_one_line(&error),
    };
    let follower = Follower::new(path, map.cloned(), Vec::new(), sink);
    let follower = RefCell::new(follower);
    match Follower::read(&follower, bytes, path) {
        Ok(_) => follower.borrow_mut().finish(),
        Err(error) => assert_one_line(&error),
    }
}

/// A CSV file of others with a map of its columns: the map, [`SEPARATOR`], the file.
pub(crate) fn foreign_csv(bytes: &[u8]) {
    let end = bytes.windows(2).position(|pair| pair == SEPARATOR);
    let (map, file) = bytes.split_at(end.unwrap_or(bytes.len()));
    let text = String::from_utf8_lossy(map);
    let map = match ColumnMap::parse(&text, Path::new("map.toml")) {
        Ok(map) => map,
        Err(error) => return assert_one_line(&error),
    };
    let folder = scratch::folder();
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("foreign.csv");
    std::fs::write(&path, file.get(2..).unwrap_or_default()).expect("a file");
    match read_mapped(&path, &Map::Columns(map)) {
        Ok(import) => {
            mcap_bytes(&import.recording, &path).expect("it can be written");
            check(&import.recording, None);
        }
        Err(error) => assert_one_line(&error),
    }
}

/// A file of others that is no bag, read without a map: a text file, whose map is guessed, or a log of SysId.
pub(crate) fn any_file(bytes: &[u8]) {
    let folder = scratch::folder();
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join("any");
    std::fs::write(&path, bytes).expect("a file");
    let guessed = match read_mapped(&path, &Map::None) {
        Ok(import) => {
            mcap_bytes(&import.recording, &path).expect("it can be written");
            check(&import.recording, None);
            import.guesses.into_iter().next()
        }
        Err(error) => return assert_one_line(&error),
    };
    let guessed = guessed.filter(|guessed| guessed.contains("guessed columns"));
    let Some((_, map)) = guessed
        .as_deref()
        .and_then(|guessed| guessed.split_once('\n'))
    else {
        return;
    };
    ColumnMap::parse(map, Path::new("map.toml")).expect("a guess is a map");
    let draft = draft_map(&path, &[]).expect("a draft");
    ColumnMap::parse(&draft, Path::new("map.toml")).expect("a draft is a map");
}

/// Separates the files of a folder in an input of the target `csv_folder`.
pub const SEPARATOR: &[u8; 2] = b"%%";

/// The files of a folder in an input of the target `csv_folder`.
pub const FILES: [&str; 10] = [
    "recording.toml",
    "robot.toml",
    "r1/command.csv",
    "r1/wheels.csv",
    "r1/pose.csv",
    "r1/imu.csv",
    "r1/odometry.csv",
    "r1/motor.csv",
    "links.csv",
    "rtt.csv",
];

/// A folder of CSV files, which survives MCAP unchanged.
pub(crate) fn csv_folder(bytes: &[u8]) {
    let [given, one, two] = ["given", "one", "two"].map(|name| scratch::folder().join(name));
    for folder in [&given, &one, &two] {
        // It does not exist the first time.
        let _ = std::fs::remove_dir_all(folder);
    }
    write_files(bytes, &given);
    let import = match read_folder(&given) {
        Ok(import) => import,
        Err(error) => return assert_one_line(&error),
    };
    let path = Path::new("fuzz.mcap");
    let bag = mcap_bytes(&import.recording, path).expect("it can be written");
    let back = read_mcap_from(&bag[..], bag.len() as u64, path).expect("and read");
    write_folder(&import.recording, &one).expect("exported");
    write_folder(&back.recording, &two).expect("exported");
    for name in FILES {
        let of = |folder: &Path| std::fs::read(folder.join(name)).ok();
        assert_eq!(of(&one), of(&two), "{name}");
    }
    check(&import.recording, None);
}

/// Writes the parts of the input to files. An empty part means that the file does not exist.
fn write_files(bytes: &[u8], folder: &Path) {
    std::fs::create_dir_all(folder.join("r1")).expect("a folder");
    let mut rest = bytes;
    for name in FILES {
        let end = rest.windows(2).position(|pair| pair == SEPARATOR);
        let (file, later) = rest.split_at(end.unwrap_or(rest.len()));
        rest = later.get(2..).unwrap_or_default();
        if !file.is_empty() {
            std::fs::write(folder.join(name), file).expect("a file");
        }
    }
}
