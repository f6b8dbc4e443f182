//! Topics that say nothing about a robot are counted and not read.

#![expect(clippy::panic, clippy::unwrap_used, reason = "helpers of tests")]

#[path = "external/python.rs"]
mod python;

use slipstream_recording::{Import, read};

const IMAGES: u64 = 60;

fn assert_complete(import: &Import, name: &str) {
    let robot = &import.recording.robots[0];
    assert_eq!(robot.wheels.as_ref().unwrap().t_s.len(), 100, "{name}");
    assert_eq!(robot.pose.as_ref().unwrap().t_s.len(), 100, "{name}");
    let left_out: Vec<(&str, u64)> = import
        .left_out
        .iter()
        .map(|(topic, messages)| (topic.as_str(), *messages))
        .collect();
    assert_eq!(left_out, [("/camera/image", IMAGES)], "{name}");
    let loss = import.loss.as_ref().unwrap();
    assert_eq!(loss.messages_read, 200 + IMAGES, "{name}");
}

/// Where the chunks of an MCAP file begin, and how long they are.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut chunks = Vec::new();
    let mut at = 8;
    while at + 9 <= bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        if bytes[at] == 0x06 {
            chunks.push((at, length));
        }
        at += 9 + length;
    }
    chunks
}

#[test]
fn chunks_of_images_are_passed_over_where_there_is_an_index() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bags");
    if python::script("write_images.py", &[&out]).is_none() {
        return;
    }
    for name in ["images.mcap", "images", "images.bag"] {
        let import = read(&out.join(name)).unwrap();
        assert_complete(&import, name);
        assert!(!import.loss.unwrap().any(), "{name}");
    }

    let mut bytes = std::fs::read(out.join("images.mcap")).unwrap();
    let all = chunks(&bytes);
    // The first chunk ends with the first image; the second and third have one image each; the last has none.
    assert_eq!(all.len() as u64, IMAGES + 1);
    let (start, length) = all[1];
    bytes[start + 9 + length - 1000] ^= 0xff;
    let damaged = out.join("damaged.mcap");
    std::fs::write(&damaged, &bytes).unwrap();
    let import = read(&damaged).unwrap();
    assert_complete(&import, "damaged");
    assert!(!import.loss.unwrap().any(), "the chunk was read");

    // An index whose checksum is wrong is not used.
    let last = bytes.len() - 100;
    bytes[last] ^= 0xff;
    std::fs::write(&damaged, &bytes).unwrap();
    let loss = read(&damaged).unwrap().loss.unwrap();
    assert_eq!(
        (loss.damaged_chunks, loss.messages_in_damaged_chunks),
        (1, 1)
    );

    // Nor is there one in a file that is cut: what stands before is read, with the images.
    let (last, _) = all[all.len() - 1];
    std::fs::write(&damaged, &bytes[..last + 20]).unwrap();
    let import = read(&damaged).unwrap();
    let loss = import.loss.unwrap();
    assert!(loss.truncated && loss.damaged_chunks == 1, "{loss}");
    assert_eq!(import.left_out["/camera/image"], IMAGES - 1);
    let wheels = import.recording.robots[0].wheels.as_ref().unwrap();
    assert_eq!(wheels.t_s.len(), 96);
}
