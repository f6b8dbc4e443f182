//! Any bytes as a folder of CSV files: an error, or a recording that survives MCAP unchanged.
//!
//! The input is split at each `%%` into the files of the folder, in a fixed order.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use slipstream_recording::{read_folder, read_mcap_from, write_folder, write_mcap_to};

const FILES: [&str; 9] = [
    "recording.toml",
    "r1/command.csv",
    "r1/wheels.csv",
    "r1/pose.csv",
    "r1/imu.csv",
    "r1/odometry.csv",
    "r1/motor.csv",
    "links.csv",
    "rtt.csv",
];

fuzz_target!(|bytes: &[u8]| {
    let scratch = tempfile::tempdir().expect("a folder");
    let given = scratch.path().join("given");
    std::fs::create_dir_all(given.join("r1")).expect("a folder");
    let mut rest = bytes;
    for name in FILES {
        let end = rest.windows(2).position(|pair| pair == b"%%").unwrap_or(rest.len());
        let (file, later) = rest.split_at(end);
        rest = later.get(2..).unwrap_or_default();
        // An empty part means that the file does not exist.
        if !file.is_empty() {
            std::fs::write(given.join(name), file).expect("a file");
        }
    }
    let import = match read_folder(&given) {
        Ok(import) => import,
        Err(error) => return assert!(!error.to_string().contains('\n'), "{error}"),
    };
    let path = Path::new("fuzz.mcap");
    let bag = write_mcap_to(&import.recording, Vec::new(), path).expect("it can be written");
    let back = read_mcap_from(&bag[..], bag.len() as u64, path).expect("and read");
    write_folder(&import.recording, &scratch.path().join("one")).expect("exported");
    write_folder(&back.recording, &scratch.path().join("two")).expect("exported");
    for name in FILES {
        let of = |folder: &str| std::fs::read(scratch.path().join(folder).join(name)).ok();
        assert_eq!(of("one"), of("two"), "{name}");
    }
});
