//! Fuzzes the target `text_file`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("text_file", input));
