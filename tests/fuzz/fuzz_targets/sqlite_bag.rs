//! Fuzzes the target `sqlite_bag`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("sqlite_bag", input));
