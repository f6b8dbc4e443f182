//! Fuzzes the target `csv_folder`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("csv_folder", input));
