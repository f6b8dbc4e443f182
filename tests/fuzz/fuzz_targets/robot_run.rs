//! Fuzzes the target `robot_run`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("robot_run", input));
