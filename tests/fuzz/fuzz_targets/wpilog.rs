//! Fuzzes the target `wpilog`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("wpilog", input));
