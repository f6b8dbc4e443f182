//! Fuzzes the target `topic_map`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("topic_map", input));
