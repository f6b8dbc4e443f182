//! Any bytes as a bag of another robot: an error in one line, or a recording that can be written.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use slipstream_recording::{TopicMap, read_mapped, write_mcap_to};

const MAP: &str = "format = 1\n[robots.a]\ncommand = \"/cmd_vel\"\nodometry = \"/odom\"\n\
    wheels = { topic = \"/joint_states\", right = \"right_wheel_joint\", left = \"left_wheel_joint\" }\n\
    pose = \"/vicon/robot/pose\"\n";

fuzz_target!(|bytes: &[u8]| {
    let scratch = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(scratch.path(), bytes).expect("a file");
    let map = TopicMap::parse(MAP, Path::new("map.toml")).expect("a map");
    for map in [None, Some(&map)] {
        match read_mapped(scratch.path(), map) {
            Ok(import) => {
                write_mcap_to(&import.recording, Vec::new(), scratch.path()).expect("written");
            }
            Err(error) => assert!(!error.to_string().contains('\n')),
        }
    }
});
