//! Fuzzes the target `trace_chunk`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("trace_chunk", input));
