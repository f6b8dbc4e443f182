//! Fuzzes the target `set_arguments`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("set_arguments", input));
