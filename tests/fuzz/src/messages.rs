//! Messages of any type, in bags that have its definition.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use slipstream_recording::{TopicMap, mcap_bytes, read_mapped_from};

use crate::one_line::assert_one_line;
use crate::recordings::SEPARATOR;

/// A map of fields of the seed's messages.
const FIELDS: &str = "format = 1\n[robots.a]\n\
    wheels = { right = { topic = \"/right_ticks\", field = \"count\" }, left = { topic = \"/left_ticks\", field = \"own[1].n\" }, \
    quantity = \"ticks\" }\n\
    command = { topic = \"/left_ticks\", right = [\"list[1]\", \"list[0]\"], left = \"speed\", quantity = \"speed\" }\n";

/// The definition of a type and messages of it, with [`SEPARATOR`] between them.
pub(crate) fn message(bytes: &[u8]) {
    let parts = parts(bytes);
    let (definition, messages) = parts.split_first().expect("one part at least");
    let path = Path::new("fuzz.mcap");
    let map = TopicMap::parse(FIELDS, Path::new("map.toml")).expect("a map");
    for encodings in [["ros2msg", "cdr"], ["ros1msg", "ros1"]] {
        let bag = bag(encodings, definition, messages);
        for map in [None, Some(&map)] {
            match read_mapped_from(&bag, path, map) {
                Ok(import) => {
                    mcap_bytes(&import.recording, path).expect("it can be written");
                }
                Err(error) => assert_one_line(&error),
            }
        }
    }
}

/// The parts of an input.
fn parts(bytes: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = bytes;
    while let Some(end) = rest.windows(2).position(|pair| pair == SEPARATOR) {
        let (part, later) = rest.split_at(end);
        parts.push(part);
        rest = later.get(2..).unwrap_or_default();
    }
    parts.push(rest);
    parts
}

/// A bag with two topics, each of which has all messages.
fn bag([form, encoding]: [&str; 2], definition: &[u8], messages: &[&[u8]]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let options = WriteOptions::new().compression(None).use_chunks(false);
    let mut writer = options.create(&mut out).expect("a writer");
    let schema = writer.add_schema("base_msgs/msg/Own", form, definition);
    let schema = schema.expect("a schema");
    for topic in ["/left_ticks", "/right_ticks"] {
        let channel = writer.add_channel(schema, topic, encoding, &BTreeMap::new());
        let channel_id = channel.expect("a channel");
        for (sequence, data) in (0..).zip(messages) {
            let time_ns = u64::from(sequence) * 50_000_000;
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time: time_ns,
                publish_time: time_ns,
            };
            let written = writer.write_to_known_channel(&header, data);
            written.expect("a message");
        }
    }
    writer.finish().expect("a file");
    drop(writer);
    out.into_inner()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_recording::recording::{Command, Wheels};

    #[test]
    fn the_seeds_are_messages_of_their_definition() {
        let seeds: [(&[u8], [&str; 2]); 2] = [
            (
                include_bytes!("../seeds/message/ros_1"),
                ["ros1msg", "ros1"],
            ),
            (include_bytes!("../seeds/message/ros_2"), ["ros2msg", "cdr"]),
        ];
        let map = TopicMap::parse(FIELDS, Path::new("map.toml")).unwrap();
        for (seed, encodings) in seeds {
            let parts = parts(seed);
            let bag = bag(encodings, parts[0], &parts[1..]);
            let import = read_mapped_from(&bag, Path::new("fuzz.mcap"), Some(&map)).unwrap();
            let robot = &import.recording.robots[0];
            let Some(Wheels::Ticks { right, left }) = robot.wheels.as_ref().map(|own| &own.values)
            else {
                panic!("no ticks");
            };
            assert_eq!((right[1], left[1]), (Some(2), Some(6)));
            let Some(Command::WheelSpeed { left_rad_s, .. }) =
                robot.command.as_ref().map(|own| &own.values)
            else {
                panic!("no speeds");
            };
            assert_eq!(left_rad_s, &[1.0, 2.0]);
        }
    }
}
