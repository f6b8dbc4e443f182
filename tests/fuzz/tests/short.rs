//! Short form of the fuzzing, on stable Rust: every target over its kept seeds and over seeded
//! mutations of them. `just fuzz` is the long form.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on says so and stops"
)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use slipstream_fuzz::mutate::Mutator;
use slipstream_fuzz::{TARGETS, Target};

/// Number of mutations of a target whose inputs are read in memory, and of one that needs files or
/// resolves whole experiments.
const FAST: u32 = 4000;
const SLOW: u32 = 400;
/// The targets of the second kind.
const SLOW_TARGETS: [&str; 7] = [
    "csv_folder",
    "foreign_csv",
    "text_file",
    "sysid_json",
    "experiment_file",
    "set_arguments",
    "round_trips",
];

/// The kept seeds of a target, sorted by name.
fn seeds(target: &Target) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("seeds")
        .join(target.name);
    let entries =
        std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect()
}

/// Runs a target; an input for which a property does not hold is kept as a file.
fn run(target: &Target, input: &[u8]) {
    let result = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    if result.is_err() {
        let name = format!("fuzz-{}", target.name);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::write(&path, input).unwrap();
        panic!("{} fails on {}", target.name, path.display());
    }
}

#[test]
fn every_target_holds_for_its_seeds_and_their_mutations() {
    std::thread::scope(|scope| {
        for target in &TARGETS {
            scope.spawn(move || {
                let seeds = seeds(target);
                assert!(!seeds.is_empty(), "{} has no seeds", target.name);
                seeds.iter().for_each(|seed| run(target, seed));
                let mut mutator = Mutator::new(1);
                let slow = SLOW_TARGETS.contains(&target.name);
                for _ in 0..if slow { SLOW } else { FAST } {
                    run(target, &mutator.input(&seeds));
                }
            });
        }
    });
}

/// A long form without nightly Rust: `SLIPSTREAM_MUTATIONS` (a million) of each target in `SLIPSTREAM_FUZZ`, with
/// commas (the descriptions of robots).
#[test]
#[ignore = "takes minutes"]
fn a_million_mutations_of_a_target() {
    let names =
        std::env::var("SLIPSTREAM_FUZZ").unwrap_or_else(|_| "urdf,controller_yaml".to_owned());
    let count = std::env::var("SLIPSTREAM_MUTATIONS").unwrap_or_else(|_| "1000000".to_owned());
    let count: u64 = count.parse().unwrap();
    for name in names.split(',') {
        let target = TARGETS.iter().find(|target| target.name == name);
        let target = target.unwrap_or_else(|| panic!("there is no target {name}"));
        let seeds = seeds(target);
        let mut mutator = Mutator::new(2);
        for _ in 0..count {
            run(target, &mutator.input(&seeds));
        }
    }
}

#[test]
fn every_target_has_a_program() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    for target in &TARGETS {
        let text =
            std::fs::read_to_string(manifest.join(format!("fuzz_targets/{}.rs", target.name)));
        assert!(text.unwrap().contains(&format!("run(\"{}\"", target.name)));
    }
}
