//! Fuzzes the target `recording_toml`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("recording_toml", input));
