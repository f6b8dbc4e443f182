//! Fuzzes the target `sysid_json`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("sysid_json", input));
