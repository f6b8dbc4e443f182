//! Any bytes as an MCAP file: an error or a recording that can be written and read again.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use slipstream_recording::{read_mcap_from, write_mcap_to};

fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("fuzz.mcap");
    let Ok(import) = read_mcap_from(bytes, bytes.len() as u64, path) else {
        return;
    };
    let written = write_mcap_to(&import.recording, Vec::new(), path).expect("it can be written");
    let again = read_mcap_from(&written[..], written.len() as u64, path).expect("and read");
    assert_eq!(again.warnings, Vec::<String>::new());
    let twice = write_mcap_to(&again.recording, Vec::new(), path).expect("and written again");
    assert!(written == twice, "to the bit");
});
