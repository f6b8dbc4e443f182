//! Fuzzes the target `round_trips`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("round_trips", input));
