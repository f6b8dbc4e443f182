//! Fuzzes the target `foreign_csv`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("foreign_csv", input));
