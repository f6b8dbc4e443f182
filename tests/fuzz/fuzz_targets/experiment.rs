//! Fuzzes the target `experiment`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("experiment", input));
