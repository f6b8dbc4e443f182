//! Any text as a robot.toml: an error in one line, or a model that round-trips.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use slipstream_recording::robot_toml::{parse, to_text};

fuzz_target!(|text: &str| {
    let path = Path::new("robot.toml");
    match parse(text, path) {
        Ok(model) => {
            let again = parse(&to_text(&model), path).expect("what was written can be read");
            // The first writing groups effects of the same name; the second must not change anything.
            assert_eq!(to_text(&again), to_text(&model));
        }
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
});
