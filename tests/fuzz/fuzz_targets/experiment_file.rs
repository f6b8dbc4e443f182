//! Fuzzes the target `experiment_file`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("experiment_file", input));
