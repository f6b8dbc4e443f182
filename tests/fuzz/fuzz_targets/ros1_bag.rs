//! Fuzzes the target `ros1_bag`.

#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| slipstream_fuzz::run("ros1_bag", input));
