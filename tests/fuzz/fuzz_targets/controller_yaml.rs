//! Fuzzes the target `controller_yaml`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("controller_yaml", input));
