//! Five small changes that somebody made who had not seen the code: they still apply, and CONTRIBUTING.md says how many files
//! each touches. `just stranger` applies them to a copy and runs their tests.

use std::path::{Path, PathBuf};
use std::process::Command;

const CHANGES: [&str; 5] = ["effect", "stream", "command", "key", "column"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn patch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("stranger/{name}.patch"))
}

/// Whether a change applies to a tree, in which one line beside each of its own is as it was.
fn applies(tree: &Path, change: &Path) -> Result<(), String> {
    let output = Command::new("git")
        .current_dir(tree)
        .args(["apply", "--check", "-C1"])
        .arg(change)
        .output();
    let output = output.map_err(|error| format!("git: {error}"))?;
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn the_changes_apply() {
    let remedy = "make the change again in a copy and write `git diff -U1` to the file, below its first lines";
    for name in CHANGES {
        let applied = applies(&root(), &patch(name));
        assert!(
            applied.is_ok(),
            "tests/stranger/{name}.patch: {applied:?}; {remedy}"
        );
    }
    let elsewhere = tempfile::tempdir().expect("a folder");
    assert!(applies(elsewhere.path(), &patch("key")).is_err());
}

#[test]
fn the_guide_counts_their_files() {
    let guide = std::fs::read_to_string(root().join("CONTRIBUTING.md")).expect("CONTRIBUTING.md");
    for name in CHANGES {
        let text = std::fs::read_to_string(patch(name)).expect(name);
        let files = text
            .lines()
            .filter(|line| line.starts_with("diff --git "))
            .count();
        assert!(
            text.lines().any(|line| line.starts_with("Run: ")),
            "{name}: no test"
        );
        let link = format!("| [{name}](tests/stranger/{name}.patch) |");
        let row = guide.lines().find(|line| line.starts_with(&link));
        let counted = row.and_then(|row| row.split('|').nth(3)).map(str::trim);
        assert_eq!(
            counted,
            Some(files.to_string().as_str()),
            "CONTRIBUTING.md: {name}"
        );
    }
}
