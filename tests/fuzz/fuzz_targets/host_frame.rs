//! Fuzzes the target `host_frame`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("host_frame", input));
