//! Fuzzes the target `trace_buffer`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("trace_buffer", input));
