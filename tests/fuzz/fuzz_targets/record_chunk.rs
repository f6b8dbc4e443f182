//! Fuzzes the target `record_chunk`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("record_chunk", input));
