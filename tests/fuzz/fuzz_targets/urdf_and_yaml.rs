//! Fuzzes the target `urdf_and_yaml`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("urdf_and_yaml", input));
