//! Fuzzes the target `bridge_frame`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("bridge_frame", input));
