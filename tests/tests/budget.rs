//! What a cold build of the program compiles: no crate twice without a reason, and no more packages than CONTRIBUTING.md says.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on says so and stops"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The machine that the budget is for. Others compile a package more or less.
const TARGET: &str = "x86_64-unknown-linux-gnu";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// What a build of `package` compiles on [`TARGET`]: a line each, as `format` says.
fn tree(package: &str, format: &str) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "-p", package, "-e", "normal,build"])
        .args(["--target", TARGET, "--prefix", "none", "--no-dedupe"])
        .args(["--format", format])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(tree.status.success(), "cargo tree: {tree:?}");
    let text = String::from_utf8(tree.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// The packages of the program: versions by name.
fn packages() -> BTreeMap<String, BTreeSet<String>> {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in tree("slipstream", "{p}") {
        let mut words = line.split_whitespace();
        if let (Some(name), Some(version)) = (words.next(), words.next()) {
            let versions = found.entry(name.to_owned()).or_default();
            versions.insert(version.to_owned());
        }
    }
    found
}

#[test]
fn no_crate_has_two_versions_without_a_reason() {
    let deny: toml::Table = read("deny.toml").parse().unwrap();
    let skip = deny["bans"]["skip"].as_array().unwrap();
    let reasoned: BTreeSet<&str> = skip
        .iter()
        .map(|entry| {
            assert!(
                entry["reason"]
                    .as_str()
                    .is_some_and(|text| !text.is_empty())
            );
            entry["crate"].as_str().unwrap()
        })
        .collect();
    let packages = packages();
    let doubled = packages.iter().filter(|(_, versions)| versions.len() > 1);
    let doubled: BTreeSet<&str> = doubled.map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        doubled, reasoned,
        "in two versions, and skipped in deny.toml"
    );
}

#[test]
fn the_number_of_packages_is_the_one_that_contributing_says() {
    let count: usize = packages().values().map(BTreeSet::len).sum();
    let text = read("CONTRIBUTING.md");
    let row = text.lines().find(|line| line.starts_with("| packages |"));
    let said = row.and_then(|row| row.split('|').nth(3)).unwrap().trim();
    assert_eq!(
        count.to_string(),
        said,
        "packages of the default build, and in the table of CONTRIBUTING.md: is what was added worth its time?"
    );
}

/// A package with other features is another package: everything that depends on it would be compiled again.
#[test]
fn program_and_python_module_are_built_of_the_same_packages() {
    let name = |line: &String| line.split(" with ").next().unwrap().to_owned();
    let program = tree("slipstream", "{p} with {f}");
    let shared: BTreeSet<String> = program.iter().map(name).collect();
    let module = tree("slipstream-python", "{p} with {f}");
    let other: Vec<&String> = module
        .difference(&program)
        .filter(|line| shared.contains(&name(line)))
        .collect();
    assert!(
        other.is_empty(),
        "with other features in the Python module: {other:#?}"
    );
}
